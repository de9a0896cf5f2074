// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "proto/model/picture.hpp"
#include "proto/model/picture_size.hpp"
#include "shaders/steady_parameters.h"

namespace fanlight {

/// Where the pixels of a depth map lie. Without a part that shows a surface there is no map.
struct MapPlace {
  PictureView view;
  PictureSize size;  ///< of the picture
};

/// The uniforms of the temporal filter, for a map and an earlier one. `target_depth_mm`: of the camera's
/// target in the first one; the body turns about it. `share`: Scene::Filter::steady, of earlier volumes.
shaders::SteadyParameters steady_parameters(const MapPlace& now, const MapPlace& earlier,
                                            double target_depth_mm, double share);

}  // namespace fanlight
