// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

namespace fanlight {

/// Copies of a picture's depth maps, mm, FANLIGHT_NO_SURFACE where there is no surface: height x width, top
/// row first.
struct DepthMaps {
  std::vector<float> cast_mm;  ///< of pass 1
  /// Edge contrast divided by the noise next to the edge, 0 without a surface. Empty where the depth filter
  /// does not weigh by it.
  std::vector<float> confidence;
  std::vector<float> smooth_mm;  ///< after pass 2's filter
  /// Share of all tiles' ray segments that rays had to sample; 1 where pass 1 skips nothing.
  double sampled_share = 1;
};

}  // namespace fanlight
