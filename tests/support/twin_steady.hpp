// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "proto/model/fan_geometry.hpp"
#include "proto/model/picture_size.hpp"
#include "proto/model/scene.hpp"

namespace fanlight::test {

/// The steady map of pass 2's temporal filter, in double precision: height x width, top row first.
struct TwinSteadyMap {
  Scene scene;  ///< of the view
  PictureSize size;
  std::vector<double> depth_mm;
  std::vector<double> volumes;  ///< in the mean of each pixel; 0 without a surface
};

/// The map of one volume alone.
TwinSteadyMap twin_single(const Scene& scene, PictureSize size, std::vector<double> depth_mm);

/// The temporal filter: `now`, a map of one volume, averaged with the steady map of an earlier one.
TwinSteadyMap twin_steady(const TwinSteadyMap& now, const TwinSteadyMap& earlier);

/// A frame of a new sweep, by the share of the last sweep's surface that is left at it, and that was left in
/// the map before.
struct TwinNewFrame {
  double angle_rad = 0;
  double share = 0;
  double share_before = 0;
};

/// The map at the seam of a rolling sweep: `now`, blended with the map of the picture before. A new frame
/// reaches `frame_step_rad` to either side.
TwinSteadyMap twin_seam(const TwinSteadyMap& now, const TwinSteadyMap& before, const FanGeometry& geometry,
                        const std::vector<TwinNewFrame>& frames, double frame_step_rad);

}  // namespace fanlight::test
