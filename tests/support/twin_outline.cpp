// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <limits>

#include "tests/support/cpu_twin.hpp"
#include "tests/support/twin_map.hpp"

namespace fanlight::test {

namespace {

/// The nearest surface of the corners, the middles of the sides and the centre of a window; infinite where
/// these lie on one surface, or have none.
double front_of(const TwinMap& map, int column, int row, int radius, double step_mm) {
  int left = column;
  int right = column;
  int top = row;
  int bottom = row;
  map.for_each_near(column, row, radius, radius, [&](int x, int y) {
    left = std::min(left, x);
    right = std::max(right, x);
    top = std::min(top, y);
    bottom = std::max(bottom, y);
  });
  constexpr double kNone = std::numeric_limits<double>::infinity();
  double nearest = kNone;
  double smallest = kNone;
  double largest = -1;
  for (const int y : {top, row, bottom}) {
    for (const int x : {left, column, right}) {
      if (map.surface(x, y)) nearest = std::min(nearest, map.depth(x, y));
      smallest = std::min(smallest, map.depth(x, y));
      largest = std::max(largest, map.depth(x, y));
    }
  }
  return largest < 0 || (smallest >= 0 && largest - smallest <= step_mm) ? kNone : nearest;
}

double weight_of(const glm::dvec2& offset, int radius) {
  return std::max(1 - glm::dot(offset, offset) / ((radius + 1) * (radius + 1)), 0.0);
}

/// What turns the share of a window that is inside a straight outline, less a half, over the mean offset
/// towards it into the distance from it: of an outline half a pixel away.
double scale_of(int radius) {
  double weights = 0;
  double inside = 0;
  double offsets = 0;
  for (int y = -radius; y <= radius; ++y) {
    for (int x = -radius; x <= radius; ++x) {
      const double weight = weight_of({x, y}, radius);
      weights += weight;
      if (x >= 0) inside += weight;
      if (x >= 0) offsets += weight * x;
    }
  }
  return 0.5 * (offsets / weights) / (inside / weights - 0.5);
}

}  // namespace

std::vector<Rgb> twin_outline(const std::vector<Rgb>& lit, const std::vector<double>& smooth_mm,
                              PictureSize size, const Scene& scene) {
  const int radius = scene.finish.outline;
  const bool shows = scene.mode == Mode::kSurface || scene.mode == Mode::kSurfaceAndVolume ||
                     scene.mode == Mode::kSlices || scene.mode == Mode::kDepth;
  if (radius == 0 || !shows) return lit;
  const TwinMap map(smooth_mm, size, viewport(scene, size));
  const double scale = scale_of(radius);
  std::vector<Rgb> outlined = lit;
  map.for_each([&](int column, int row) {
    const double front_mm = front_of(map, column, row, radius, scene.filter.step_mm);
    if (std::isinf(front_mm)) return;
    const auto is_front = [&](int x, int y) {
      return map.surface(x, y) && map.depth(x, y) <= front_mm + scene.filter.step_mm;
    };
    double weights = 0;
    double inside = 0;
    glm::dvec2 offsets(0);
    glm::dvec2 inside_offsets(0);
    map.for_each_near(column, row, radius, radius, [&](int x, int y) {
      const glm::dvec2 offset(x - column, y - row);
      const double weight = weight_of(offset, radius);
      weights += weight;
      offsets += weight * offset;
      if (!is_front(x, y)) return;
      inside += weight;
      inside_offsets += weight * offset;
    });
    const double share = inside / weights;
    const double towards = glm::length(inside_offsets - share * offsets) / weights;
    const double covered = std::clamp(0.5 + (share - 0.5) * scale / std::max(towards, 1e-9), 0.0, 1.0);
    const bool front = is_front(column, row);
    Rgb others(0);
    int count = 0;
    map.for_each_near(column, row, 1, 1, [&](int x, int y) {
      if (is_front(x, y) == front) return;
      others += lit[map.index(x, y)] * lit[map.index(x, y)];
      ++count;
    });
    if (count == 0) return;
    const Rgb here = lit[map.index(column, row)] * lit[map.index(column, row)];
    outlined[map.index(column, row)] =
        glm::sqrt(glm::mix(others / static_cast<double>(count), here, front ? covered : 1 - covered));
  });
  return outlined;
}

}  // namespace fanlight::test
