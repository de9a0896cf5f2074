// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

namespace fanlight {

enum class SweepDirection : std::uint8_t { kForward, kBackward };

/// Identity, position and time of one 2D frame. The pixels are passed separately: a source writes them
/// directly to the memory that the assembler provides (8 bit, row major, row 0 nearest the probe).
struct FrameStamp {
  std::uint64_t sequence = 0;         ///< counts every frame of a source from 0; a gap means lost frames
  std::uint64_t volume_index = 0;     ///< sweep of the frame; never decreases
  std::uint32_t frame_index = 0;      ///< index in the sweep, in order of arrival
  std::uint32_t frames_in_sweep = 0;  ///< 0 where the source does not know it before the sweep ends
  SweepDirection direction = SweepDirection::kForward;
  double angle_rad = 0;                 ///< measured motor angle
  std::uint32_t geometry_revision = 0;  ///< changes whenever the source's geometry changes
  /// The source was interrupted before this frame (the probe was unplugged): the open sweep will not
  /// continue.
  bool after_interruption = false;
  std::int64_t capture_time_ns = 0;  ///< steady clock of this host (fanlight::now_ns)
  /// Counts the frames committed by the assembler, from 1. Unique in a process, which has one assembler. 0:
  /// not known; sources leave it 0.
  std::uint64_t commit_number = 0;
  /// Its number in the recording that is played, the same in each pass; absent: no recording is played.
  std::optional<std::uint64_t> recorded_number{};

  /// A number by which a recording of the source, and a replay of it, know the frame.
  std::uint64_t number_in_recording() const { return recorded_number.value_or(sequence); }
};

/// Reason why a received frame is unusable; selects its counter.
enum class FrameFault : std::uint8_t {
  kNone,
  kInvalid,  ///< marked as invalid by its source
  kDamaged,  ///< its checksum is wrong
  kCut,      ///< it ended before its last pixel
  kMisfit,   ///< its size, pixel format or geometry differs from the source's
};

}  // namespace fanlight
