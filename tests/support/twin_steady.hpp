// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

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

}  // namespace fanlight::test
