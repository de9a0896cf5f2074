#pragma once

#include <cstdint>

namespace fanlight {

enum class SweepDirection : std::uint8_t { kForward, kBackward };

/// Identity, place and time of one 2D frame. The pixels travel apart from it: a source writes them
/// straight into the memory that the assembler names (8 bit, row major, row 0 nearest the probe).
struct FrameStamp {
  std::uint64_t sequence = 0;         ///< counts every frame of a source from 0; a gap is a lost frame
  std::uint64_t volume_index = 0;     ///< the sweep it belongs to; never decreases
  std::uint32_t frame_index = 0;      ///< place in the sweep, in order of arrival
  std::uint32_t frames_in_sweep = 0;  ///< 0 where the source does not know before the sweep ends
  SweepDirection direction = SweepDirection::kForward;
  double angle_rad = 0;                 ///< measured motor angle
  std::uint32_t geometry_revision = 0;  ///< changes whenever the source's geometry does
  /// The source was interrupted before this frame (the probe was unplugged): the sweep that was under way
  /// will not go on.
  bool after_interruption = false;
  std::int64_t capture_time_ns = 0;  ///< steady clock of this host (fanlight::now_ns)
  /// Counts the frames that an assembler has committed, from 1: no two frames of a process, which has one
  /// assembler, have the same. 0: not known; sources leave it so.
  std::uint64_t arrival = 0;
};

/// Why a frame that came is of no use; the name of the counter that it moves.
enum class FrameFault : std::uint8_t {
  kNone,
  kInvalid,  ///< marked so by its maker
  kDamaged,  ///< its checksum is wrong
  kCut,      ///< it ended before its last pixel
  kMisfit,   ///< its size, pixel format or geometry is not the source's
};

}  // namespace fanlight
