// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string_view>

namespace fanlight {

/// One row of the benchmark: a source, and the scene and size of its picture.
struct BenchRow {
  std::string_view name;
  std::string_view input;          ///< as for `fanlight render`
  int picture = 512;               ///< side of the picture in pixels
  std::string_view method;         ///< scene fields that several rows share, "name=value name=value"
  std::string_view settings;       ///< further scene fields, which override those of `method`
  std::string_view geometry_path;  ///< for a recording without its geometry
  std::string_view changes;        ///< fields of the user, which override all; as `method`
};

/// R1, the reference workload (35 frames of 512 x 512 over 70 deg, 16 cm deep, a 512 x 512 picture), and
/// variants of it.
std::span<const BenchRow> bench_rows();

}  // namespace fanlight
