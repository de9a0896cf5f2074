// SPDX-License-Identifier: Apache-2.0
#include "proto/model/fan_sampler.hpp"

#include <algorithm>
#include <cmath>

#include "proto/model/scanned_sector.hpp"

namespace fanlight {

FanSampler::FanSampler(const Volume& volume)
    : volume_(volume),
      geometry_(volume.geometry()),
      knows_border_(geometry_.kind != FrameKind::kCartesian || geometry_.sector.half_angle_deg > 0 ||
                    geometry_.zero_is_unscanned) {
  for (const std::uint32_t frame : volume.by_angle()) angles_rad_.push_back(volume.angles_rad()[frame]);
}

std::optional<FanSampler::Between> FanSampler::around(double angle_rad) const {
  if (angle_rad < angles_rad_.front() || angle_rad > angles_rad_.back()) return std::nullopt;
  const auto above = std::ranges::upper_bound(angles_rad_, angle_rad);
  const std::size_t second =
      std::clamp<std::ptrdiff_t>(above - angles_rad_.begin(), 1, std::ssize(angles_rad_) - 1);
  const double step_rad = angles_rad_[second] - angles_rad_[second - 1];
  return Between{.first = volume_.frame_pixels(volume_.by_angle()[second - 1]),
                 .second = volume_.frame_pixels(volume_.by_angle()[second]),
                 .share = step_rad > 0 ? (angle_rad - angles_rad_[second - 1]) / step_rad : 0};
}

/// Of the four pixels from `index` on.
bool FanSampler::has_zero(std::span<const std::uint8_t> pixels, std::size_t index) const {
  const std::size_t below = index + geometry_.columns;
  return std::min({pixels[index], pixels[index + 1], pixels[below], pixels[below + 1]}) == 0;
}

std::optional<double> FanSampler::echo(const Between& frames, const PlanePoint& point) const {
  const FramePlace place = geometry_.frame_place(point);
  if (!(place.column >= 0 && place.column <= geometry_.columns - 1.0 && place.row >= 0 &&
        place.row <= geometry_.rows - 1.0) ||
      !in_sector(geometry_, place.column, place.row))
    return std::nullopt;
  const auto column = std::min(static_cast<std::uint32_t>(place.column), geometry_.columns - 2);
  const auto row = std::min(static_cast<std::uint32_t>(place.row), geometry_.rows - 2);
  const double right = place.column - column;
  const double down = place.row - row;
  const std::size_t index = std::size_t{row} * geometry_.columns + column;
  if (geometry_.zero_is_unscanned && (has_zero(frames.first, index) || has_zero(frames.second, index)))
    return std::nullopt;
  const auto bilinear = [&](std::span<const std::uint8_t> pixels) {
    const double upper = std::lerp(double{1} * pixels[index], double{1} * pixels[index + 1], right);
    const std::size_t below = index + geometry_.columns;
    const double lower = std::lerp(double{1} * pixels[below], double{1} * pixels[below + 1], right);
    return std::lerp(upper, lower, down);
  };
  return std::lerp(bilinear(frames.first), bilinear(frames.second), frames.share);
}

std::uint8_t FanSampler::at(const Between& frames, const PlanePoint& point) const {
  const auto found = echo(frames, point);
  if (!found) return 0;
  // 0 is left to what was not scanned, where that is known.
  return static_cast<std::uint8_t>(std::max(knows_border_ ? 1L : 0L, std::lround(*found)));
}

}  // namespace fanlight
