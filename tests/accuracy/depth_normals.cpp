// SPDX-License-Identifier: Apache-2.0
#include "tests/accuracy/depth_normals.hpp"

#include <cmath>
#include <glm/geometric.hpp>

#include "tests/accuracy/depth_errors.hpp"

namespace fanlight::test {

std::optional<double> DepthNormals::depth_mm(int column, int row) const {
  const int width = static_cast<int>(size_.width);
  if (column < 0 || row < 0 || column >= width || row >= static_cast<int>(size_.height)) return std::nullopt;
  const double depth_mm = depth_mm_[static_cast<std::size_t>(row) * size_.width + column];
  return depth_mm >= 0 ? std::optional(depth_mm) : std::nullopt;
}

std::optional<double> DepthNormals::neighbour_mm(int column, int row, double depth_mm) const {
  const auto found = this->depth_mm(column, row);
  if (found && kind_ == Normals::kCentral && std::abs(*found - depth_mm) > step_mm_) return std::nullopt;
  return found;
}

glm::dvec3 DepthNormals::place(int column, int row, double depth_mm) const {
  return rays_.place(static_cast<std::uint32_t>(column), static_cast<std::uint32_t>(row), depth_mm);
}

glm::dvec3 DepthNormals::tangent(int column, int row, int right, int down) const {
  const double here_mm = *depth_mm(column, row);
  const glm::dvec3 here = place(column, row, here_mm);
  const auto next = neighbour_mm(column + right, row + down, here_mm);
  const auto before = neighbour_mm(column - right, row - down, here_mm);
  const auto next_place = [&] { return place(column + right, row + down, *next); };
  const auto place_before = [&] { return place(column - right, row - down, *before); };
  if (kind_ == Normals::kCentral && next && before) return next_place() - place_before();
  if (next) return next_place() - here;
  if (before) return here - place_before();
  return place(column + right, row + down, here_mm) - here;
}

std::optional<glm::dvec3> DepthNormals::at(int column, int row) const {
  if (!depth_mm(column, row)) return std::nullopt;
  const glm::dvec3 across = glm::cross(tangent(column, row, 1, 0), -tangent(column, row, 0, 1));
  return glm::normalize(rays_.in_body(across));
}

std::vector<double> normal_errors_deg(const DepthNormals& normals, std::span<const float> shown_mm,
                                      std::span<const PixelTruth> truth, const PixelRays& rays,
                                      PictureSize size, const KnownSurface& surface) {
  std::vector<double> errors_deg;
  for (std::size_t pixel = 0; pixel < truth.size(); ++pixel) {
    if (truth[pixel].meets != Meets::kSurface || shown_mm[pixel] < 0) continue;
    if (std::abs(shown_mm[pixel] - truth[pixel].depth_mm) > kFoundMm) continue;
    const auto column = static_cast<std::uint32_t>(pixel % size.width);
    const auto row = static_cast<std::uint32_t>(pixel / size.width);
    const auto shown = normals.at(static_cast<int>(column), static_cast<int>(row));
    const glm::dvec3 known = surface.normal(rays.ray(column, row).at(truth[pixel].depth_mm));
    errors_deg.push_back(degrees(std::acos(std::clamp(glm::dot(*shown, known), -1.0, 1.0))));
  }
  return errors_deg;
}

}  // namespace fanlight::test
