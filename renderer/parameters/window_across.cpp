// SPDX-License-Identifier: Apache-2.0
#include "renderer/parameters/window_across.hpp"

#include <cmath>
#include <numbers>

#include "shaders/cast_parameters.h"

namespace fanlight {

std::vector<glm::dvec2> points_across(int window) {
  // Along each axis a grid of n points a step apart has the variance (n^2 - 1) / 12, and a ring of three
  // points the variance r^2 / 2. The rings share the area of a disc of this radius.
  const double disc_squared = (window * window - 1) / 3.0;
  const int rings = window / 2;
  std::vector<glm::dvec2> points;
  for (int ring = 0; ring < rings; ++ring) {
    const double radius = std::sqrt(disc_squared * (ring + 0.5) / rings);
    for (int number = 0; number < FANLIGHT_ACROSS_POINTS; ++number) {
      // Each ring is turned by half of the angle between its points against the one before.
      const double angle = (2 * number + ring % 2) * std::numbers::pi / FANLIGHT_ACROSS_POINTS;
      points.emplace_back(radius * std::sin(angle), radius * std::cos(angle));
    }
  }
  return points;
}

}  // namespace fanlight
