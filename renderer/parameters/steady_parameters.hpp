// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "proto/model/picture.hpp"
#include "proto/model/picture_size.hpp"
#include "proto/model/scene.hpp"
#include "shaders/steady_parameters.h"

namespace fanlight {

/// Where the pixels of a depth map lie. Without a part that shows a surface there is no map.
struct MapPlace {
  PictureView view;
  PictureSize size;  ///< of the picture
};

/// A steady map that a new map may be averaged with.
struct EarlierMap {
  MapPlace place;
  bool has_volume = false;  ///< the new map's volume is part of it: it adds no count
};

/// Whether two scenes find the surface at the same place: they have the same detector, speckle filter, near
/// tissue and samples along rays. What one of them cuts away, the maps themselves tell.
bool finds_same_surface(const Scene& first, const Scene& second);

/// Whether the maps of two scenes differ in the view only: the same is cut away, and rays are as dense.
bool differs_in_view_alone(const Scene& first, const Scene& second);

/// The map that was cast by `mapped` and filtered, for a map that is cast by `scene`; absent where that finds
/// the surface elsewhere. `usual`: size of scenes that have none.
std::optional<EarlierMap> earlier_map(const Scene& mapped, PictureSize usual, const Scene& scene,
                                      bool has_volume);

/// The uniforms of the temporal filter, for a map and an earlier one. `target_depth_mm`: of the camera's
/// target in the first one; the body turns about it. `share`: Scene::Filter::steady, of earlier volumes.
shaders::SteadyParameters steady_parameters(const MapPlace& now, const EarlierMap& earlier,
                                            double target_depth_mm, double share);

}  // namespace fanlight
