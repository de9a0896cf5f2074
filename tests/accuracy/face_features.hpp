// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "renderer/parameters/view_frame.hpp"

namespace fanlight::test {

/// A part of the face that stands out of its surroundings, or a groove, where the face is seen along the
/// depth axis.
struct FaceFeature {
  std::string_view name;
  // Where it is sought: about a point, mm from the middle of the picture, right and up.
  double right_mm = 0;
  double up_mm = 0;
  double within_mm = 0;
  /// Its surroundings: a circle of this radius about each point.
  double ring_mm = 0;
  bool is_groove = false;
};

/// The point that stands out most, or lies deepest, and by how much it differs from the mean of the depths on
/// the circle about it.
struct FoundFeature {
  double right_mm = 0;
  double up_mm = 0;
  double height_mm = 0;  ///< positive: towards the viewer, or into the groove
};

/// Of a depth map, height x width, top row first, mm, negative without a surface. nullopt where no point of
/// the window has a whole circle on a surface.
std::optional<FoundFeature> found_feature(const FaceFeature& feature, std::span<const double> depth_mm,
                                          PictureSize size, double pixel_mm);

}  // namespace fanlight::test
