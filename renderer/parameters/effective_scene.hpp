// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "proto/model/echo_levels.hpp"
#include "proto/model/fan_geometry.hpp"
#include "proto/model/scene.hpp"
#include "renderer/parameters/view_frame.hpp"

namespace fanlight {

/// The scene with a number for everything that it leaves to the data or gives in mm: samples in the
/// detector's window, pixels in the windows of the speckle filter and of the depth filter (their fields in mm
/// are 0 then), threshold and noise. Windows are limited to the ranges of their fields. Without known levels,
/// the defaults of Scene.
///
/// `usual`: the size of a picture whose scene has none. In a finer picture the windows of the depth filter,
/// of islands and of holes cover the same length in the body.
Scene effective_scene(const Scene& scene, const FanGeometry& geometry, PictureSize usual,
                      const EchoLevels& levels);

}  // namespace fanlight
