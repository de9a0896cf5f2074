#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "proto/volume.hpp"

namespace fanlight {

/// Every frame of a sweep in 16 x 16 grey levels: enough to see by what angle two sweeps are apart.
/// Allocates in the constructor alone. One thread, the acquisition thread.
class SweepThumbnails {
 public:
  static constexpr std::uint32_t kSide = 16;
  using Blocks = std::array<float, std::size_t{kSide} * kSide>;  ///< mean grey level, row major

  explicit SweepThumbnails(std::uint32_t frame_capacity);

  void clear() { frames_ = 0; }

  /// Replaces what is here by a volume's frames in ascending order of their angle, as its angles stand now.
  /// `frames` holds its stamps in order of arrival. Reads 256 rows of each frame at most.
  /// Precondition: the volume is sorted and has at most frame_capacity frames.
  void take(const Volume& volume, std::span<const FrameStamp> frames);

  std::uint32_t frames() const { return frames_; }
  bool empty() const { return frames_ == 0; }
  const FanGeometry& geometry() const { return geometry_; }
  double angle_rad(std::uint32_t frame) const { return angles_rad_[frame]; }
  double time_s(std::uint32_t frame) const { return times_s_[frame]; }  ///< of the host's steady clock
  const Blocks& blocks(std::uint32_t frame) const { return blocks_[frame]; }

 private:
  FanGeometry geometry_;
  std::uint32_t frames_ = 0;
  std::vector<double> angles_rad_;
  std::vector<double> times_s_;
  std::vector<Blocks> blocks_;
};

}  // namespace fanlight
