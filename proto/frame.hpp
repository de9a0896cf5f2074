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
  double angle_rad = 0;              ///< measured motor angle
  std::int64_t capture_time_ns = 0;  ///< steady clock of this host (fanlight::now_ns)
};

}  // namespace fanlight
