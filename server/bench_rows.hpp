#pragma once

#include <span>
#include <string_view>

namespace fanlight {

/// One row of the benchmark: a source and what is asked of its picture.
struct BenchRow {
  std::string_view name;
  std::string_view input;          ///< as for `fanlight render`
  int picture = 512;               ///< its side, pixels
  std::string_view method;         ///< scene fields that rows share, "name=value name=value"
  std::string_view settings;       ///< others, which win
  std::string_view geometry_path;  ///< of a recording that does not say its geometry
};

/// R1, the reference work (35 frames of 512 x 512 over 70 deg, 16 cm deep, a 512 x 512 picture), and its
/// neighbours.
std::span<const BenchRow> bench_rows();

}  // namespace fanlight
