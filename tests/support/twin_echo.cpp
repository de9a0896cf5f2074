// SPDX-License-Identifier: Apache-2.0
#include "tests/support/twin_echo.hpp"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

namespace fanlight::test {

namespace {

double voxel(const Volume& volume, int column, int row, int position) {
  const FanGeometry& geometry = volume.geometry();
  const int last_frame = static_cast<int>(volume.by_angle().size()) - 1;
  column = std::min(column, static_cast<int>(geometry.columns) - 1);
  row = std::min(row, static_cast<int>(geometry.rows) - 1);
  position = std::min(position, last_frame);
  const auto frame = volume.frame_pixels(volume.by_angle()[static_cast<std::size_t>(position)]);
  return frame[static_cast<std::size_t>(row) * geometry.columns + static_cast<std::size_t>(column)] / 255.0;
}

bool in_sector(const Scene::Speckle& speckle, const FanGeometry& geometry, PlanePoint at) {
  const FanGeometry::Sector& sector = geometry.sector;
  if (geometry.kind != FrameKind::kCartesian || sector.half_angle_deg == 0) return true;
  // The guided filter takes means of means, so its reach is two windows.
  const int windows = speckle.filter == SpeckleFilter::kNone     ? 0
                      : speckle.filter == SpeckleFilter::kGuided ? 2
                                                                 : 1;
  const int pixels = 1 + windows * (speckle.size / 2);
  const double margin_mm = std::max(geometry.pixel_width_mm, geometry.pixel_height_mm) * pixels;
  const double from_apex_mm = at.depth_mm + geometry.probe_radius_mm;
  const double reach_mm = std::hypot(at.x_mm, from_apex_mm);
  return std::abs(at.x_mm) + margin_mm <= from_apex_mm * std::tan(radians(sector.half_angle_deg)) &&
         reach_mm >= geometry.probe_radius_mm + margin_mm &&
         (sector.reach_mm == 0 || reach_mm <= sector.reach_mm - margin_mm);
}

/// Column, row and frame of a point; nullopt outside the frames.
std::optional<glm::dvec3> voxel_place(const Scene::Speckle& speckle, const Volume& volume,
                                      const glm::dvec3& at) {
  const FanGeometry& geometry = volume.geometry();
  const FanCoordinate fan = geometry.fan_coordinate(at.y, at.z);
  const auto [column, row] = geometry.frame_place({at.x, fan.depth_mm});
  if (column < 0 || column > geometry.columns - 1 || row < 0 || row > geometry.rows - 1 ||
      !in_sector(speckle, geometry, {at.x, fan.depth_mm})) {
    return std::nullopt;
  }
  const auto frame = frame_coordinate(volume, fan.angle_rad);
  if (!frame) return std::nullopt;
  return glm::dvec3(column, row, *frame);
}

}  // namespace

std::optional<double> frame_coordinate(const Volume& volume, double angle_rad) {
  const auto order = volume.by_angle();
  const auto angle = [&](std::size_t position) { return volume.angles_rad()[order[position]]; };
  if (angle_rad < angle(0) || angle_rad > angle(order.size() - 1)) return std::nullopt;
  std::size_t below = 0;
  while (below + 2 < order.size() && angle(below + 1) <= angle_rad) ++below;
  const double step = angle(below + 1) - angle(below);
  return static_cast<double>(below) + (step > 0 ? (angle_rad - angle(below)) / step : 0);
}

bool is_within_frames(const Scene::Speckle& speckle, const Volume& prepared, const glm::dvec3& at) {
  return voxel_place(speckle, prepared, at).has_value();
}

std::optional<double> twin_echo(const Scene::Speckle& speckle, const Volume& prepared, const glm::dvec3& at) {
  const FanGeometry& geometry = prepared.geometry();
  const auto place = voxel_place(speckle, prepared, at);
  if (!place) return std::nullopt;
  const glm::dvec3 base = glm::floor(*place);
  const glm::dvec3 fraction = *place - base;
  double value = 0;
  double darkest = 1;
  for (int corner = 0; corner < 8; ++corner) {
    const int right = corner & 1;
    const int down = corner >> 1 & 1;
    const int next = corner >> 2;
    const double weight = (right != 0 ? fraction.x : 1 - fraction.x) *
                          (down != 0 ? fraction.y : 1 - fraction.y) *
                          (next != 0 ? fraction.z : 1 - fraction.z);
    const double echo = voxel(prepared, static_cast<int>(base.x) + right, static_cast<int>(base.y) + down,
                              static_cast<int>(base.z) + next);
    value += weight * echo;
    darkest = std::min(darkest, echo);
  }
  if (geometry.zero_is_unscanned && darkest == 0) return std::nullopt;
  return value;
}

}  // namespace fanlight::test
