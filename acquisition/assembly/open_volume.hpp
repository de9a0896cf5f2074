// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "acquisition/source/angle_check.hpp"
#include "proto/exchange/doorbell.hpp"
#include "proto/exchange/volume_ring.hpp"
#include "proto/model/frame.hpp"
#include "proto/model/volume.hpp"

namespace fanlight {

/// The volume of the open sweep: its memory in the ring, and the stamps of its frames in order of arrival.
/// Counts nothing. One thread, the acquisition thread. Allocates in the constructor only.
///
/// Life: empty -> open() -> add() ... -> publish() or abandon() -> empty.
class OpenVolume {
 public:
  /// Both must outlive this object. `writer_bell`: rung by the ring when a slot becomes free.
  OpenVolume(VolumeRing& ring, Doorbell& writer_bell);

  bool is_open() const { return volume_ != nullptr; }
  /// 0 where no volume is open.
  std::uint32_t frames() const { return is_open() ? volume_->stamp().frames : 0; }

  /// Takes a slot of the ring for frames of this geometry. Blocks only where the ring processes all volumes
  /// and has no free slot. False where `stop` ended that wait, or such frames do not fit. Precondition:
  /// !is_open().
  bool open(const FanGeometry& geometry, const std::stop_token& stop);

  // Precondition of the following: is_open().

  Volume& operator*() { return *volume_; }
  Volume* operator->() { return volume_; }
  const Volume& operator*() const { return *volume_; }
  const Volume* operator->() const { return volume_; }
  std::span<const FrameStamp> stamps() const { return std::span(stamps_).first(frames()); }

  /// Adds the frame that was written to Volume::next_frame_pixels().
  void add(const FrameStamp& frame);

  /// What the check of the angles has found and removed.
  struct Angles {
    AngleCheck::Findings findings;
    std::uint32_t removed = 0;      ///< frames with an outlier
    std::uint64_t longest_run = 0;  ///< of them, in order of capture
  };
  /// Removes the frames whose angle is an outlier, and sets the volume's span to what is left.
  Angles remove_outliers();

  /// Whether the angle moved enough for a volume.
  bool has_moved() const;

  /// Frames of a sweep that ended before them.
  struct Rest {
    const Volume& volume;
    std::uint32_t first = 0;
    std::uint32_t frames = 0;
  };
  /// Keeps the first `kept` frames only. The others stay where they are until the next open().
  Rest cut(std::uint32_t kept);
  /// Opens a volume and adds the frames of cut(); false as open(). Precondition: !is_open(), and no open()
  /// since cut().
  bool carry_over(const Rest& rest, const std::stop_token& stop);

  /// Passes the volume to the reader of the ring, or gives it back.
  void publish();
  void abandon();

 private:
  Volume* wait_for_volume(const std::stop_token& stop);

  VolumeRing& ring_;
  Doorbell& writer_bell_;
  Volume* volume_ = nullptr;
  std::vector<FrameStamp> stamps_;
  AngleCheck angle_check_;
  std::vector<std::uint32_t> by_sequence_;          // indices of the frames, while their angles are checked
  std::vector<AngleCheck::Frame> frames_to_check_;  // in that order
};

}  // namespace fanlight
