#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "acquisition/frame_source.hpp"
#include "proto/scene.hpp"
#include "renderer/gpu.hpp"
#include "server/bench_rows.hpp"

namespace fanlight {

/// Times of one row, ms, by what was done: "new_volume", "camera", "light", the stages of a new volume's
/// picture, ...; each in the order of the rounds.
struct BenchTimes {
  std::map<std::string, std::vector<double>> ms;
  double surface_share = 0;  ///< of the picture's pixels
};

/// Runs a row `rounds` times, after one round that counts nothing. In each round, in turn:
///   new_volume    the last frame of a volume has come, the others were there and prepared -> its picture
///   whole_volume  all of a volume comes at once -> its picture
///   camera        the camera turns by a degree -> the picture of the same volume
///   light_moved   the light moves -> the same
///   frame         a frame comes and replaces its place in the last sweep -> its picture (each of a sweep)
///   cast_unskipped: pass 1 alone, of whole_volume, with nothing passed over
Result<BenchTimes> run_bench_row(const Gpu& gpu, const BenchRow& row, int rounds);

/// The scene of a row: the source's, with the row's settings.
Result<Scene> bench_scene(const BenchRow& row, const SourceDescription& source);

/// The value below which that share of the times lies.
double quantile(std::vector<double> times_ms, double share);

}  // namespace fanlight
