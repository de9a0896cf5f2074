// SPDX-License-Identifier: Apache-2.0
#include "renderer/survey/volume_profiles.hpp"

#include <algorithm>
#include <cmath>

#include "proto/model/scanned_sector.hpp"

namespace fanlight {

VolumeProfiles::VolumeProfiles(const Volume& volume, const std::stop_token& stop)
    : geometry_(volume.geometry()) {
  const auto order = volume.by_angle();
  across_ = std::min(geometry_.columns, kMostAcross);
  frames_ = std::min(static_cast<std::uint32_t>(order.size()), kMostFrames);
  rows_in_cell_ = std::max(1U, static_cast<std::uint32_t>(std::lround(kCellMm / geometry_.pixel_height_mm)));
  cell_mm_ = rows_in_cell_ * geometry_.pixel_height_mm;
  cells_ = geometry_.rows / rows_in_cell_;
  levels_.assign(std::size_t{frames_} * across_ * cells_, kNoData);
  for (std::uint32_t frame = 0; frame < frames_ && !stop.stop_requested(); ++frame) {
    const auto index = order[(2 * std::size_t{frame} + 1) * order.size() / (2 * std::size_t{frames_})];
    angles_rad_.push_back(volume.angles_rad()[index]);
    fill(volume, frame, index);
  }
}

void VolumeProfiles::fill(const Volume& volume, std::uint32_t frame, std::uint32_t index) {
  const auto pixels = volume.frame_pixels(index);
  for (std::uint32_t line = 0; line < across_; ++line) {
    const std::uint32_t first = line * geometry_.columns / across_;
    const std::uint32_t end = (line + 1) * geometry_.columns / across_;
    const double middle = (first + end - 1) / 2.0;
    float* const levels = &levels_[(std::size_t{frame} * across_ + line) * cells_];
    bool any_echo = false;
    for (std::uint32_t cell = 0; cell < cells_; ++cell) {
      const std::uint32_t row = cell * rows_in_cell_;
      if (!in_sector(geometry_, middle, row + (rows_in_cell_ - 1) / 2.0)) continue;
      std::uint32_t sum = 0;
      std::uint8_t darkest = 255;
      for (std::uint32_t each = row; each < row + rows_in_cell_; ++each) {
        for (std::uint32_t column = first; column < end; ++column) {
          const std::uint8_t pixel = pixels[std::size_t{each} * geometry_.columns + column];
          sum += pixel;
          darkest = std::min(darkest, pixel);
        }
      }
      if (geometry_.zero_is_unscanned && darkest == 0) continue;
      // Before the first echo lies the border of the scanner's picture.
      any_echo |= sum > 0;
      if (any_echo)
        levels[cell] = static_cast<float>(sum) / static_cast<float>(rows_in_cell_ * (end - first));
    }
    for (std::uint32_t cell = cells_; cell-- > 0 && levels[cell] <= 0;) levels[cell] = kNoData;
  }
}

double VolumeProfiles::middle_column(std::uint32_t profile) const {
  const std::uint32_t line = profile % across_;
  const std::uint32_t first = line * geometry_.columns / across_;
  const std::uint32_t end = (line + 1) * geometry_.columns / across_;
  return (first + end - 1) / 2.0;
}

double VolumeProfiles::end_cell(std::uint32_t profile, const NearTissue& near) const {
  return near.end_row_at(geometry_, middle_column(profile), angles_rad_[profile / across_]) / rows_in_cell_;
}

glm::dvec3 VolumeProfiles::position(std::uint32_t profile, double cell) const {
  const PlanePoint at = geometry_.plane_point(
      {.column = middle_column(profile), .row = cell * rows_in_cell_ + (rows_in_cell_ - 1) / 2.0});
  const Point point =
      geometry_.point(at.x_mm, {.angle_rad = angles_rad_[profile / across_], .depth_mm = at.depth_mm});
  return {point.x_mm, point.y_mm, point.z_mm};
}

}  // namespace fanlight
