// SPDX-License-Identifier: Apache-2.0
// CPU twin of the edges behind a surface that is shown as glass (shaders/glass_layers.h).
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "tests/support/cpu_twin.hpp"
#include "tests/support/twin_ray.hpp"

namespace fanlight::test {

/// The samples of a ray, in which a layer is looked for.
struct LayeredRay {
  const Scene& scene;
  const Volume& prepared;
  Ray ray;
  const std::vector<std::optional<double>>& values;  ///< 0 to 1; nullopt: not scanned
  double depth_step_mm;                              ///< from one to the next
  double surface_edge;                               ///< its position, in samples from the first
};

/// The layers behind the surface as pass 1 keeps them: opacity, and the normal to the right and upwards,
/// which is 0.5 without one. `is_shown`: whether an edge at this depth is neither cropped nor cut away.
Rgb twin_layers(const LayeredRay& layered, const std::function<bool(double depth_mm)>& is_shown);

/// Pass 2: the binomial mean of the layers over 3 x 3 pixels of the viewport (shaders/glass.h): opacity, and
/// the normal to the right and upwards.
inline glm::dvec3 layers_about(const std::vector<Rgb>& kept, PictureSize size, const Scene& scene, int column,
                               int row) {
  const Viewport part = viewport(scene, size);
  const auto within = [](int at, std::uint32_t first, std::uint32_t count) {
    return static_cast<std::size_t>(
        std::clamp(at, static_cast<int>(first), static_cast<int>(first + count) - 1));
  };
  glm::dvec3 sum(0);
  for (const int down : {-1, 0, 1}) {
    for (const int right : {-1, 0, 1}) {
      const Rgb& there = kept[within(row + down, part.top, part.height) * size.width +
                              within(column + right, part.left, part.width)];
      const double weight = (2 - std::abs(right)) * (2 - std::abs(down)) / 16.0;
      if (there.x > 0) sum += weight * glm::dvec3(there.x, 2 * there.y - 1, 2 * there.z - 1);
    }
  }
  return sum;
}

}  // namespace fanlight::test
