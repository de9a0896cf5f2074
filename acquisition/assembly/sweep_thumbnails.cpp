// SPDX-License-Identifier: Apache-2.0
#include "acquisition/assembly/sweep_thumbnails.hpp"

#include <algorithm>
#include <numeric>

namespace fanlight {

namespace {

// Per row of blocks. Neighbouring rows share their speckle: more of them would cost time and add little
// information.
constexpr std::uint32_t kRowsRead = 16;

SweepThumbnails::Blocks block_means(std::span<const std::uint8_t> pixels, const FanGeometry& geometry) {
  constexpr std::uint32_t kSide = SweepThumbnails::kSide;
  SweepThumbnails::Blocks means{};
  for (std::uint32_t down = 0; down < kSide; ++down) {
    const std::uint32_t top = geometry.rows * down / kSide;
    const std::uint32_t bottom = geometry.rows * (down + 1) / kSide;
    const std::uint32_t step = std::max(1U, (bottom - top) / kRowsRead);
    for (std::uint32_t across = 0; across < kSide; ++across) {
      const std::uint32_t left = geometry.columns * across / kSide;
      const std::uint32_t right = geometry.columns * (across + 1) / kSide;
      std::uint32_t sum = 0;
      std::uint32_t count = 0;
      for (std::uint32_t row = top; row < bottom; row += step) {
        const auto in_row = pixels.subspan(std::size_t{row} * geometry.columns + left, right - left);
        sum = std::accumulate(in_row.begin(), in_row.end(), sum);
        count += right - left;
      }
      // Blocks stay empty where a frame has fewer pixels than blocks.
      if (count > 0) {
        means[down * kSide + across] = static_cast<float>(sum) / static_cast<float>(count);
      }
    }
  }
  return means;
}

}  // namespace

SweepThumbnails::SweepThumbnails(std::uint32_t frame_capacity)
    : angles_rad_(frame_capacity), times_s_(frame_capacity), blocks_(frame_capacity) {}

void SweepThumbnails::take(const Volume& volume, std::span<const FrameStamp> frames) {
  geometry_ = volume.geometry();
  frames_ = 0;
  for (const std::uint32_t frame : volume.by_angle()) {
    angles_rad_[frames_] = volume.angles_rad()[frame];
    times_s_[frames_] = static_cast<double>(frames[frame].capture_time_ns) * 1e-9;
    blocks_[frames_] = block_means(volume.frame_pixels(frame), geometry_);
    ++frames_;
  }
}

}  // namespace fanlight
