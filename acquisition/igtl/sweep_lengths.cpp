// SPDX-License-Identifier: Apache-2.0
#include "acquisition/igtl/sweep_lengths.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "proto/model/fan_geometry.hpp"

namespace fanlight {

namespace {

constexpr double kLeastReturnRad = radians(0.2);
constexpr double kReturnShare = 0.1;
constexpr std::uint32_t kMostNamed = 100'000;  // no sweep has more; sums with it do not wrap

/// The parts between changes of the sweep.
struct Parts {
  std::uint32_t longest = 0;
  std::uint32_t count = 0;

  void add(std::uint32_t frames) {
    longest = std::max(longest, frames);
    ++count;
  }
};

Parts by_index(std::span<const FrameNotes> images) {
  Parts parts;
  std::uint32_t frames = 0;
  for (std::size_t i = 0; i < images.size(); ++i) {
    if (i > 0 && images[i].volume_index != images[i - 1].volume_index) parts.add(std::exchange(frames, 0));
    ++frames;
    parts.longest = std::max(parts.longest, std::min(images[i].frames_in_sweep.value_or(0), kMostNamed));
  }
  parts.add(frames);
  return parts;
}

Parts by_turning(std::span<const std::optional<double>> angles_rad) {
  Parts parts;
  double lowest = std::numeric_limits<double>::infinity();
  double highest = -lowest;
  double extreme = 0;
  std::size_t extreme_at = 0;
  std::size_t began = 0;
  int direction = 0;
  for (std::size_t i = 0; i < angles_rad.size(); ++i) {
    if (!angles_rad[i]) continue;
    const double angle = *angles_rad[i];
    lowest = std::min(lowest, angle);
    highest = std::max(highest, angle);
    const double back = std::max(kLeastReturnRad, kReturnShare * (highest - lowest));
    if (direction == 0) {
      if (highest - lowest <= back) continue;
      direction = angle == highest ? 1 : -1;
      extreme = angle;
      extreme_at = i;
    } else if (direction * (angle - extreme) > 0) {
      extreme = angle;
      extreme_at = i;
    } else if (direction * (extreme - angle) > back) {
      parts.add(static_cast<std::uint32_t>(extreme_at - began + 1));
      began = extreme_at + 1;
      direction = -direction;
      extreme = angle;
      extreme_at = i;
    }
  }
  parts.add(static_cast<std::uint32_t>(angles_rad.size() - began));
  return parts;
}

}  // namespace

SweepLengths sweep_lengths(std::span<const FrameNotes> images,
                           std::span<const std::optional<double>> angles_rad) {
  SweepLengths lengths;
  lengths.counted = std::ranges::all_of(
      images, [](const FrameNotes& each) { return each.volume_index && each.frame_index; });
  const Parts parts = lengths.counted ? by_index(images) : by_turning(angles_rad);
  // The first and the last part may be cut off; one between them is whole.
  lengths.enough = parts.count >= 3;
  lengths.longest = parts.longest;
  // Where angles turn, the reversal is noticed some frames later.
  lengths.capacity = lengths.counted ? parts.longest + parts.longest / 4 + 8 : parts.longest * 3 / 2 + 16;
  lengths.smallest_rad = std::numeric_limits<double>::infinity();
  lengths.largest_rad = -lengths.smallest_rad;
  for (const auto& angle_rad : angles_rad) {
    if (!angle_rad) continue;
    lengths.smallest_rad = std::min(lengths.smallest_rad, *angle_rad);
    lengths.largest_rad = std::max(lengths.largest_rad, *angle_rad);
  }
  return lengths;
}

}  // namespace fanlight
