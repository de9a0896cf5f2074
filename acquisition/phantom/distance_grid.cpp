// SPDX-License-Identifier: Apache-2.0
#include "acquisition/phantom/distance_grid.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace fanlight {

namespace {

constexpr int kCoarse = 4;  // nodes in a step of the coarse grid

float interpolated(const std::array<float, 8>& corners, const glm::vec3& share) {
  const auto along_x = [&](int corner) {
    return corners[corner] + share.x * (corners[corner + 1] - corners[corner]);
  };
  const float near = along_x(0) + share.y * (along_x(2) - along_x(0));
  const float far = along_x(4) + share.y * (along_x(6) - along_x(4));
  return near + share.z * (far - near);
}

template <typename At>
std::array<float, 8> corners_of(const glm::ivec3& cell, At at) {
  std::array<float, 8> corners{};
  for (int corner = 0; corner < 8; ++corner)
    corners[corner] = at(cell + glm::ivec3(corner & 1, corner >> 1 & 1, corner >> 2));
  return corners;
}

}  // namespace

DistanceGrid::DistanceGrid(Shape shape, const glm::vec3& lowest_mm, const glm::vec3& highest_mm,
                           float spacing_mm)
    : lowest_mm_(lowest_mm), nodes_per_mm_(1 / spacing_mm) {
  const glm::ivec3 coarse_cells = glm::ivec3(glm::ceil((highest_mm - lowest_mm) * nodes_per_mm_ / 4.0F));
  nodes_ = kCoarse * coarse_cells + 1;
  highest_mm_ = lowest_mm + spacing_mm * glm::vec3(nodes_ - 1);
  const glm::ivec3 coarse_nodes = coarse_cells + 1;
  const std::vector<float> values = coarse(shape, coarse_nodes);
  const auto coarse_at = [&](const glm::ivec3& at) {
    return values[(static_cast<std::size_t>(at.z) * coarse_nodes.y + at.y) * coarse_nodes.x + at.x];
  };
  // A cell that the surface crosses has a corner within half of its diagonal, and the shape may call that
  // half as much again.
  const float far_mm = 1.5F * 0.5F * std::sqrt(3.0F) * kCoarse * spacing_mm;
  values_.resize(static_cast<std::size_t>(nodes_.x) * nodes_.y * nodes_.z);
  float* to = values_.data();
  glm::ivec3 at{};
  for (at.z = 0; at.z < nodes_.z; ++at.z) {
    for (at.x = 0; at.x < nodes_.x; ++at.x) {
      for (at.y = 0; at.y < nodes_.y; ++at.y) {
        const glm::ivec3 cell = glm::min(at / kCoarse, coarse_cells - 1);
        const auto corners = corners_of(cell, coarse_at);
        float nearest = std::abs(corners[0]);
        for (const float corner : corners) nearest = std::min(nearest, std::abs(corner));
        *to++ = nearest > far_mm
                    ? interpolated(corners, glm::vec3(at - kCoarse * cell) / static_cast<float>(kCoarse))
                    : shape(lowest_mm_ + spacing_mm * glm::vec3(at));
      }
    }
  }
}

std::vector<float> DistanceGrid::coarse(Shape shape, const glm::ivec3& nodes) const {
  std::vector<float> values;
  glm::ivec3 at{};
  for (at.z = 0; at.z < nodes.z; ++at.z) {
    for (at.y = 0; at.y < nodes.y; ++at.y) {
      for (at.x = 0; at.x < nodes.x; ++at.x)
        values.push_back(shape(lowest_mm_ + static_cast<float>(kCoarse) / nodes_per_mm_ * glm::vec3(at)));
    }
  }
  return values;
}

float DistanceGrid::at(const glm::vec3& at_mm) const {
  const glm::vec3 inside = glm::clamp(at_mm, lowest_mm_, highest_mm_);
  const glm::vec3 place = (inside - lowest_mm_) * nodes_per_mm_;
  const glm::ivec3 cell = glm::min(glm::ivec3(place), nodes_ - 2);
  const glm::vec3 share = place - glm::vec3(cell);
  const float* const first = &values_[index_of(cell)];
  const std::size_t next_x = nodes_.y;
  const std::size_t next_z = next_x * nodes_.x;
  const auto along_y = [&](const float* from) { return from[0] + share.y * (from[1] - from[0]); };
  const auto plane = [&](const float* from) {
    const float left = along_y(from);
    return left + share.x * (along_y(from + next_x) - left);
  };
  const float near = plane(first);
  const float value = near + share.z * (plane(first + next_z) - near);
  if (inside == at_mm || value <= 0) return value;
  const float beside_mm = glm::distance(inside, at_mm);
  return std::max(beside_mm, value - beside_mm);
}

}  // namespace fanlight
