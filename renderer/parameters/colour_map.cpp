// SPDX-License-Identifier: Apache-2.0
#include "renderer/parameters/colour_map.hpp"

namespace fanlight {

std::array<glm::dvec3, FANLIGHT_MAP_POINTS> colour_map_points(ColourMap map) {
  const glm::dvec3 black(0, 0, 0);
  switch (map) {
    case ColourMap::kSepia:
      return {black, {0.29, 0.20, 0.13}, {0.69, 0.56, 0.40}, {1.00, 0.95, 0.84}};
    case ColourMap::kGold:
      return {black, {0.45, 0.20, 0.02}, {0.85, 0.55, 0.12}, {1.00, 0.95, 0.70}};
    case ColourMap::kIce:
      return {black, {0.05, 0.22, 0.45}, {0.35, 0.62, 0.85}, {0.92, 0.98, 1.00}};
    case ColourMap::kHeat:
      return {black, {0.55, 0.00, 0.00}, {1.00, 0.55, 0.00}, {1.00, 1.00, 0.85}};
    case ColourMap::kNone:
    case ColourMap::kGrey:
      break;
  }
  return {black, glm::dvec3(1.0 / 3), glm::dvec3(2.0 / 3), glm::dvec3(1)};
}

}  // namespace fanlight
