// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "proto/model/scene.hpp"
#include "proto/model/volume.hpp"
#include "renderer/parameters/view_frame.hpp"

namespace fanlight {

/// A scene that shows what find_surface() found, and a sentence for each choice.
struct AutoScene {
  Scene scene;
  std::vector<std::string> choices;
  bool is_sure = true;  ///< false: the surface is small or torn, and slices beside it show more
};

/// `scene`: what is not chosen stays as it is here. nullopt: the volume has no surface that stands out, and a
/// slice shows more of it; or a stop was requested. Deterministic.
std::optional<AutoScene> auto_scene(const Volume& volume, const Scene& scene, const PictureSize& size,
                                    const std::stop_token& stop = {});

}  // namespace fanlight
