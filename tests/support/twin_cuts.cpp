// SPDX-License-Identifier: Apache-2.0
#include "tests/support/twin_cuts.hpp"

#include <algorithm>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "renderer/parameters/cast_parameters.hpp"

namespace fanlight::test {

namespace {

using glm::dvec3;

dvec3 vector(const CutList::Vector& from) {
  return {from[0], from[1], from[2]};
}

/// By the even-odd rule.
bool is_inside(std::span<const float> outline, double x, double y) {
  const std::size_t corners = outline.size() / 2;
  bool inside = false;
  for (std::size_t corner = 0; corner < corners; ++corner) {
    const std::size_t next = (corner + 1) % corners;
    const double y0 = outline[2 * corner + 1];
    const double y1 = outline[2 * next + 1];
    if ((y0 > y) == (y1 > y)) continue;
    const double x0 = outline[2 * corner];
    const double x1 = outline[2 * next];
    if (x < x0 + (y - y0) / (y1 - y0) * (x1 - x0)) inside = !inside;
  }
  return inside;
}

bool lasso_cuts(const CutList::Cut& cut, std::span<const float> outline, const dvec3& at) {
  const dvec3 right = vector(cut.right);
  const dvec3 up = vector(cut.up);
  const dvec3 from = at - vector(cut.origin);
  const double depth_mm = glm::dot(from, glm::cross(up, right));
  if (depth_mm < cut.nearest_mm || depth_mm > cut.farthest_mm) return false;
  const double scale = cut.eye_mm > 0 ? (depth_mm + cut.eye_mm) / cut.eye_mm : 1;
  if (scale <= 0) return false;
  const bool inside = is_inside(outline, glm::dot(from, right) / scale, glm::dot(from, up) / scale);
  return inside == (cut.kind == CutList::Kind::kInside);
}

bool balls_cut(double radius_mm, std::span<const float> centres, const dvec3& at) {
  for (std::size_t number = 0; number < centres.size(); number += 3) {
    const dvec3 centre(centres[number], centres[number + 1], centres[number + 2]);
    if (glm::length(at - centre) <= radius_mm) return true;
  }
  return false;
}

VolumeExtent extent_of(const Volume& volume) {
  const auto [first, last] = std::ranges::minmax(volume.angles_rad());
  return {.first_angle_rad = first, .last_angle_rad = last};
}

}  // namespace

TwinCuts::TwinCuts(const Scene& scene, const Volume& volume)
    : list_(scene.cuts.shapes), grid_(cut_grid(volume.geometry(), extent_of(volume))) {}

bool TwinCuts::cuts_corner(const dvec3& corner) const {
  return std::ranges::any_of(list_.cuts(), [&](const CutList::Cut& cut) {
    const auto numbers = list_.numbers(cut);
    return cut.kind == CutList::Kind::kBalls ? balls_cut(ball_radius_mm(cut, grid_), numbers, corner)
                                             : lasso_cuts(cut, numbers, corner);
  });
}

double TwinCuts::share(const dvec3& at) const {
  if (list_.empty()) return 0;
  const dvec3 place = (at - grid_.lowest) / grid_.cell_mm;
  const dvec3 cell = glm::clamp(glm::floor(place), dvec3(0), dvec3(grid_.cells) - 1.0);
  const dvec3 part = glm::clamp(place - cell, 0.0, 1.0);
  double share = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const dvec3 offset(corner & 1, corner >> 1 & 1, corner >> 2);
    const dvec3 weight = glm::mix(1.0 - part, part, offset);
    if (cuts_corner(grid_.lowest + grid_.cell_mm * (cell + offset))) share += weight.x * weight.y * weight.z;
  }
  return share;
}

}  // namespace fanlight::test
