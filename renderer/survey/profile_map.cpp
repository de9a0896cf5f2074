// SPDX-License-Identifier: Apache-2.0
#include "renderer/survey/profile_map.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace fanlight {

ProfileMap::ProfileMap(const VolumeProfiles& profiles)
    : profiles_(profiles), cells_(profiles.profiles()), known_(profiles.profiles()) {}

void ProfileMap::set(std::uint32_t profile, double cell) {
  cells_[profile] = cell;
  known_[profile] = true;
}

void ProfileMap::fill() {
  for (bool any = true; any;) {
    any = false;
    std::vector<bool> grown = known_;
    for (std::uint32_t profile = 0; profile < cells_.size(); ++profile) {
      if (known_[profile]) continue;
      double sum = 0;
      int count = 0;
      for_neighbours(profile, 1, [&](std::uint32_t other, double) {
        if (!known_[other]) return;
        sum += cells_[other];
        ++count;
      });
      if (count == 0) continue;
      cells_[profile] = sum / count;
      grown[profile] = any = true;
    }
    known_ = std::move(grown);
  }
}

double ProfileMap::mean_around(const std::vector<double>& cells, std::uint32_t profile) const {
  double sum = 0;
  double weights = 0;
  for_neighbours(profile, 1, [&](std::uint32_t other, double weight) {
    sum += weight * cells[other];
    weights += weight;
  });
  return sum / weights;
}

/// In cells, at a profile of each frame, with a fraction, and at an angle.
double ProfileMap::at(double across, double angle_rad) const {
  const double column = std::clamp(across, 0.0, profiles_.across() - 1.0);
  const double frame = frame_at(angle_rad);
  const auto left = std::min(static_cast<std::uint32_t>(column), profiles_.across() - 2);
  const auto below = std::min(static_cast<std::uint32_t>(frame), profiles_.frames() - 2);
  const double* const from = &cells_[std::size_t{below} * profiles_.across() + left];
  const double* const next = from + profiles_.across();
  return std::lerp(std::lerp(from[0], from[1], column - left), std::lerp(next[0], next[1], column - left),
                   frame - below);
}

double ProfileMap::frame_at(double angle_rad) const {
  std::uint32_t above = 1;
  while (above + 1 < profiles_.frames() && profiles_.angle_rad(above) < angle_rad) ++above;
  const double below_rad = profiles_.angle_rad(above - 1);
  const double step_rad = profiles_.angle_rad(above) - below_rad;
  const double share = step_rad > 0 ? (angle_rad - below_rad) / step_rad : 0;
  return above - 1 + std::clamp(share, 0.0, 1.0);
}

std::optional<NearTissue> ProfileMap::near_tissue(const Volume& volume) const {
  const auto order = volume.by_angle();
  NearTissue found{.first_angle_rad = volume.angles_rad()[order.front()],
                   .last_angle_rad = volume.angles_rad()[order.back()]};
  if (!(found.last_angle_rad > found.first_angle_rad)) return std::nullopt;
  const double rows = profiles_.cell_mm() / volume.geometry().pixel_height_mm;
  const double columns = volume.geometry().columns;
  for (std::uint32_t z = 0; z < NearTissue::kAround; ++z) {
    const double angle_rad =
        std::lerp(found.first_angle_rad, found.last_angle_rad, z / (NearTissue::kAround - 1.0));
    for (std::uint32_t x = 0; x < NearTissue::kAcross; ++x) {
      // A profile lies in the middle of its columns.
      const double column = x / (NearTissue::kAcross - 1.0) * (columns - 1);
      const double cell = at((column + 0.5) / columns * profiles_.across() - 0.5, angle_rad);
      found.end_row[std::size_t{z} * NearTissue::kAcross + x] = static_cast<float>(cell * rows);
    }
  }
  return found;
}

}  // namespace fanlight
