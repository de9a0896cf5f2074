// SPDX-License-Identifier: Apache-2.0
#include "acquisition/assembly/ring_check.hpp"

#include <algorithm>
#include <cmath>
#include <span>

namespace fanlight {

namespace {

constexpr std::uint32_t kFrames = 16;
constexpr std::uint32_t kLines = 16;
constexpr std::uint32_t kRows = 128;
constexpr std::uint32_t kBeside = 16;  // samples of a place, 4 x 4: rings are finer than the places
// Of the depth: the face itself rises too steeply for pixels, and the picture may end before its last row.
constexpr double kNearest = 0.04;
constexpr double kFarthest = 0.98;
// Of the depth: rings are brightest next to the lens, a plate in a bath is not.
constexpr double kLastBrightest = 0.2;
constexpr float kLeastRange = 24;  // grey levels, from the darkest to the brightest depth
constexpr float kApart = 0.25F;    // of that range
constexpr float kMostLevels = 20;  // and no more grey levels: a dim body behind a bright lens differs by more
// Of all places: less than a thin sheet takes, and more than noise. A flat interface in a bath crosses each
// line once.
constexpr double kMostApart = 0.001;

/// Place in the frame of a sample, both coordinates from 0 to 1: across the lines, and along them.
FramePlace sample_place(const FanGeometry& geometry, double across, double along) {
  along = std::lerp(kNearest, kFarthest, along);
  if (geometry.kind != FrameKind::kCartesian || geometry.sector.half_angle_deg == 0)
    return {across * (geometry.columns - 1), along * (geometry.rows - 1)};
  const double radius_mm = geometry.probe_radius_mm;
  const double reach_mm =
      geometry.sector.reach_mm > 0 ? geometry.sector.reach_mm : radius_mm + geometry.depth_mm();
  // Not to the very border, where the picture is black on one side.
  const double angle_rad = radians(0.95 * geometry.sector.half_angle_deg * (2 * across - 1));
  const double from_apex_mm = std::lerp(radius_mm, reach_mm, along);
  return geometry.frame_place(
      {from_apex_mm * std::sin(angle_rad), from_apex_mm * std::cos(angle_rad) - radius_mm});
}

}  // namespace

RingCheck::RingCheck()
    : places_(std::size_t{kLines} * kRows * kBeside),
      profiles_(std::size_t{kFrames} * kLines * kRows),
      mean_(kRows) {}

void RingCheck::place_lines(const FanGeometry& geometry) {
  auto place = places_.begin();
  for (std::uint32_t line = 0; line < kLines; ++line) {
    for (std::uint32_t row = 0; row < kRows; ++row) {
      for (std::uint32_t beside = 0; beside < kBeside; ++beside) {
        const std::uint32_t across = beside % 4;
        const std::uint32_t along = beside / 4;
        const FramePlace at =
            sample_place(geometry, (line + (across + 0.5) / 4) / kLines, (row + (along + 0.5) / 4) / kRows);
        const double column = std::clamp(std::round(at.column), 0.0, geometry.columns - 1.0);
        const double down = std::clamp(std::round(at.row), 0.0, geometry.rows - 1.0);
        *place++ = static_cast<std::uint32_t>(down) * geometry.columns + static_cast<std::uint32_t>(column);
      }
    }
  }
  geometry_ = geometry;
}

bool RingCheck::shows_rings(const Volume& volume) {
  if (geometry_ != volume.geometry()) place_lines(volume.geometry());
  const std::uint32_t frames = std::min(kFrames, volume.stamp().frames);
  const float share = 1.0F / static_cast<float>(frames * kLines);
  std::ranges::fill(mean_, 0.0F);
  auto profile = profiles_.begin();
  for (std::uint32_t n = 0; n < frames; ++n) {
    const auto pixels = volume.frame_pixels(volume.by_angle()[n * volume.stamp().frames / frames]);
    auto place = places_.begin();
    for (std::uint32_t line = 0; line < kLines; ++line) {
      for (std::uint32_t row = 0; row < kRows; ++row) {
        std::uint32_t sum = 0;
        for (std::uint32_t beside = 0; beside < kBeside; ++beside) sum += pixels[*place++];
        *profile = static_cast<float>(sum) / kBeside;
        mean_[row] += share * *profile++;
      }
    }
  }
  const auto [darkest, brightest] = std::ranges::minmax_element(mean_);
  const float range = *brightest - *darkest;
  if (range < kLeastRange || static_cast<double>(brightest - mean_.begin()) > kLastBrightest * kRows)
    return false;
  const auto all = static_cast<std::size_t>(profile - profiles_.begin());
  const float tolerated = std::min(kApart * range, kMostLevels);
  std::size_t apart = 0;
  for (std::size_t i = 0; i < all; ++i) {
    // A place may be off by a part of a pixel.
    const std::size_t row = i % kRows;
    const std::size_t first = std::max<std::size_t>(row, 1) - 1;
    const auto [least, most] =
        std::ranges::minmax(std::span(mean_).subspan(first, std::min<std::size_t>(row + 2, kRows) - first));
    if (profiles_[i] < least - tolerated || profiles_[i] > most + tolerated) ++apart;
  }
  return static_cast<double>(apart) < kMostApart * static_cast<double>(all);
}

}  // namespace fanlight
