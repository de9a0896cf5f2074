// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <glm/vec3.hpp>

#include "proto/model/scene.hpp"
#include "shaders/light_parameters.h"

namespace fanlight {

/// The displayed colours (sRGB, 0 to 1) of a map for a brightness of 0, 1/3, 2/3 and 1; linear in between.
std::array<glm::dvec3, FANLIGHT_MAP_POINTS> colour_map_points(ColourMap map);

}  // namespace fanlight
