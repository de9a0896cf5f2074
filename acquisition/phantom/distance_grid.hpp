// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <vector>

namespace fanlight {

/// The signed distance to a surface in mm, negative inside, kept at the nodes of a regular grid. The
/// trilinear interpolation of the grid is the exact surface: tests compare with it.
///
/// Immutable after construction: any thread may read it.
class DistanceGrid {
 public:
  /// A signed distance, or a bound of it: the surface may be nearer by a third, but not farther.
  using Shape = float (*)(const glm::vec3& at_mm);

  /// Samples the shape in a box. Near the surface at each node, `spacing_mm` apart; elsewhere at every
  /// fourth.
  DistanceGrid(Shape shape, const glm::vec3& lowest_mm, const glm::vec3& highest_mm, float spacing_mm);

  /// Outside the box: at most the distance, so that a step of that length never crosses the surface; inside a
  /// body that leaves the box, the value at the border. Where a surface leaves the box, what lies next to it
  /// is not known.
  float at(const glm::vec3& at_mm) const;

  // A sphere around the box.
  glm::vec3 middle_mm() const { return 0.5F * (lowest_mm_ + highest_mm_); }
  float radius_mm() const { return 0.5F * glm::distance(lowest_mm_, highest_mm_); }

 private:
  std::size_t index_of(const glm::ivec3& node) const {
    return (static_cast<std::size_t>(node.z) * nodes_.x + node.x) * nodes_.y + node.y;
  }
  std::vector<float> coarse(Shape shape, const glm::ivec3& nodes) const;

  glm::vec3 lowest_mm_;
  glm::vec3 highest_mm_;
  float nodes_per_mm_;
  glm::ivec3 nodes_{0};
  std::vector<float> values_;  // nodes_.z x nodes_.x x nodes_.y: scan lines run along y
};

}  // namespace fanlight
