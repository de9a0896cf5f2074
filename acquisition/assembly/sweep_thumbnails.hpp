// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "proto/model/volume.hpp"

namespace fanlight {

/// Each frame of a sweep reduced to 16 x 16 grey levels: enough to estimate the angle between two sweeps.
/// Allocates in the constructor only. One thread, the acquisition thread.
class SweepThumbnails {
 public:
  static constexpr std::uint32_t kSide = 16;
  using Blocks = std::array<float, std::size_t{kSide} * kSide>;  ///< mean grey level, row major

  explicit SweepThumbnails(std::uint32_t frame_capacity);

  void clear() { frames_ = 0; }

  /// Replaces the content by the frames of a volume, in ascending order of their present angles. `frames`:
  /// its stamps in order of arrival. Reads at most 256 rows of each frame. Precondition: the volume is sorted
  /// and has at most frame_capacity frames.
  void take(const Volume& volume, std::span<const FrameStamp> frames);

  std::uint32_t frames() const { return frames_; }
  bool empty() const { return frames_ == 0; }
  const FanGeometry& geometry() const { return geometry_; }
  double angle_rad(std::uint32_t frame) const { return angles_rad_[frame]; }
  double time_s(std::uint32_t frame) const { return times_s_[frame]; }  ///< on the host's steady clock
  const Blocks& blocks(std::uint32_t frame) const { return blocks_[frame]; }

 private:
  FanGeometry geometry_;
  std::uint32_t frames_ = 0;
  std::vector<double> angles_rad_;
  std::vector<double> times_s_;
  std::vector<Blocks> blocks_;
};

}  // namespace fanlight
