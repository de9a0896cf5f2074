// SPDX-License-Identifier: Apache-2.0
#include "acquisition/convert/grid_volume.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>

#include "proto/model/fan_geometry.hpp"
#include "proto/model/fan_sampler.hpp"

namespace fanlight {

namespace {

constexpr double kLeastSpacingMm = 0.01;
constexpr double kMostSpacingMm = 50;  // few voxels would be left of any body
constexpr double kMostSide = 4096;

struct Bounds {
  std::array<double, 3> least{};
  std::array<double, 3> most{};
};

double smallest_angle_rad(const Volume& volume) {
  return volume.angles_rad()[volume.by_angle().front()];
}
double largest_angle_rad(const Volume& volume) {
  return volume.angles_rad()[volume.by_angle().back()];
}

/// The box around the fan. Its extremes lie at the outermost angles, and where the fan looks straight ahead.
Bounds bounds_of(const Volume& volume) {
  const FanGeometry& geometry = volume.geometry();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Bounds box{.least = {geometry.left_mm(), kInfinity, kInfinity},
             .most = {geometry.right_mm(), -kInfinity, -kInfinity}};
  const double first_rad = smallest_angle_rad(volume);
  const double last_rad = largest_angle_rad(volume);
  for (const double angle_rad : {first_rad, last_rad, std::clamp(0.0, first_rad, last_rad)}) {
    for (const double depth_mm :
         {std::max(geometry.nearest_mm(), -geometry.motor_radius_mm), geometry.depth_mm()}) {
      const Point point = geometry.point(0, {.angle_rad = angle_rad, .depth_mm = depth_mm});
      box.least[1] = std::min(box.least[1], point.y_mm);
      box.most[1] = std::max(box.most[1], point.y_mm);
      box.least[2] = std::min(box.least[2], point.z_mm);
      box.most[2] = std::max(box.most[2], point.z_mm);
    }
  }
  return box;
}

}  // namespace

double usual_spacing_mm(const Volume& volume) {
  constexpr double kVoxels = 256;
  constexpr double kStepMm = 0.05;
  const Bounds box = bounds_of(volume);
  double longest_mm = 0;
  for (int axis = 0; axis < 3; ++axis) longest_mm = std::max(longest_mm, box.most[axis] - box.least[axis]);
  return std::max(kStepMm, std::ceil(longest_mm / kVoxels / kStepMm) * kStepMm);
}

Result<GridVolume> scan_converted(const Volume& volume, double spacing_mm, const Progress& progress,
                                  std::uint64_t most_voxels) {
  if (!(spacing_mm >= kLeastSpacingMm && spacing_mm <= kMostSpacingMm)) {
    return Error{ErrorCode::kInvalidArgument, fmt::format("the spacing is {} mm, expected {} to {} mm",
                                                          spacing_mm, kLeastSpacingMm, kMostSpacingMm)};
  }
  const Bounds box = bounds_of(volume);
  GridVolume grid{.origin_mm = box.least, .spacing_mm = spacing_mm};
  double voxels = 1;
  double longest = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double side = std::floor((box.most[axis] - box.least[axis]) / spacing_mm) + 1;
    longest = std::max(longest, side);
    voxels *= side;
    if (side <= kMostSide) grid.size[axis] = static_cast<std::uint32_t>(side);
  }
  if (!(longest <= kMostSide) || !(voxels <= static_cast<double>(most_voxels))) {
    return Error{
        ErrorCode::kInvalidArgument,
        fmt::format("a spacing of {} mm makes {:.0f} million voxels, {:.0f} on the longest side; expected a "
                    "larger one, for at most {} million voxels and {:.0f} a side",
                    spacing_mm, voxels / 1e6, longest, most_voxels / 1'000'000, kMostSide)};
  }
  try {
    grid.voxels.resize(grid.bytes());
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::kUnavailable,
                 fmt::format("a grid of {} bytes finds no memory, expected as much or a larger spacing",
                             grid.bytes())};
  }
  const FanSampler sampler(volume);
  std::uint8_t* voxel = grid.voxels.data();
  for (std::uint32_t k = 0; k < grid.size[2]; ++k) {
    for (std::uint32_t j = 0; j < grid.size[1]; ++j) {
      const FanCoordinate at = volume.geometry().fan_coordinate(grid.origin_mm[1] + j * spacing_mm,
                                                                grid.origin_mm[2] + k * spacing_mm);
      const auto frames = sampler.around(at.angle_rad);
      for (std::uint32_t i = 0; i < grid.size[0]; ++i, ++voxel) {
        if (frames)
          *voxel = sampler.at(*frames, {.x_mm = grid.origin_mm[0] + i * spacing_mm, .depth_mm = at.depth_mm});
      }
    }
    if (!progress((k + 1.0) / grid.size[2])) return Error{ErrorCode::kStopped, "the conversion was stopped"};
  }
  return grid;
}

}  // namespace fanlight
