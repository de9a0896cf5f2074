// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "renderer/vulkan/render_device.hpp"
#include "server/bench/rows.hpp"

namespace fanlight {

/// Times of one row in ms, by name: "new_volume", "camera", "light", the stages of a new volume's picture,
/// ... Each list is in the order of the rounds.
struct BenchTimes {
  std::map<std::string, std::vector<double>> ms;
  double surface_share = 0;  ///< of the pixels of the picture, 0 to 1
};

/// Runs a row `rounds` times, after one round that is not counted. Each round measures the time to the
/// picture after:
///   new_volume      the last frame of a volume is received; the others were received and prepared before
///   whole_volume    all frames of a volume are received at once
///   camera          the camera turns by a degree; the volume stays
///   light_moved     the light moves; the volume stays
///   frame           one frame is received and replaces a frame of the last sweep (for each frame of a sweep)
///   cast_unskipped  as whole_volume, but pass 1 alone and without empty-space skipping
Result<BenchTimes> run_bench_row(const RenderDevice& device, const BenchRow& row, int rounds);

/// The quantile of the times for a share from 0 to 1; 0 without times.
double quantile(std::vector<double> times_ms, double share);

}  // namespace fanlight
