// SPDX-License-Identifier: Apache-2.0
#include "tests/support/twin_edges.hpp"

#include <algorithm>
#include <cmath>

namespace fanlight::test {

std::vector<double> window_heights(const Scene::Detector& detector, const std::vector<double>& run) {
  const std::size_t half = static_cast<std::size_t>(detector.window) / 2;
  std::vector<double> heights;
  for (std::size_t oldest = 0; oldest + 2 * half <= run.size(); ++oldest) {
    double sum = 0;
    for (std::size_t at = oldest; at < oldest + half; ++at) sum += run[at + half] - run[at];
    const double step = sum / static_cast<double>(half);
    heights.push_back(detector.sign == EdgeSign::kEither         ? std::abs(step)
                      : detector.sign == EdgeSign::kDarkToBright ? step
                                                                 : -step);
  }
  return heights;
}

SteepestWindow steepest_window(const std::vector<double>& heights, std::size_t first, double threshold) {
  std::size_t peak = first;
  for (std::size_t at = first + 1; at < heights.size(); ++at) {
    if (heights[at] <= std::max(threshold, heights[peak] / 2)) break;
    if (heights[at] > heights[peak]) peak = at;
  }
  const double position = static_cast<double>(peak);
  if (peak == 0 || peak + 1 == heights.size()) return {.position = position, .height = heights[peak]};
  const double curvature = heights[peak - 1] - 2 * heights[peak] + heights[peak + 1];
  if (curvature >= 0) return {.position = position, .height = heights[peak]};
  const double offset = std::clamp(0.5 * (heights[peak - 1] - heights[peak + 1]) / curvature, -0.5, 0.5);
  return {.position = position + offset, .height = heights[peak]};
}

}  // namespace fanlight::test
