// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <stop_token>

#include "acquisition/source/frame_source.hpp"
#include "proto/exchange/frame_tap.hpp"

namespace fanlight {

/// Where a frame finds no room in the tap's queue.
enum class FullQueue : std::uint8_t {
  kLoseFrame,  ///< a probe does not wait
  kWait,       ///< a source without a pace of its own does
};

/// What a pump saw.
struct PumpedFrames {
  std::uint64_t frames = 0;
  std::uint64_t lost = 0;  ///< sequence numbers that never came, where those are losses
  /// Frames that came after an interruption: a probe that was unplugged, a replay at the other end that
  /// jumped. How many frames did not come meanwhile is not known.
  std::uint64_t interruptions = 0;
};

/// Passes all frames of a source to a tap, until the source ends or a stop is requested. Nothing is assembled
/// or rendered. `pumped`: valid also after an error. Blocks; the thread of the source. Errors: the source's.
Result<void> pump_frames(FrameSource& source, FrameTap& tap, FullQueue full, const std::stop_token& stop,
                         PumpedFrames& pumped);

}  // namespace fanlight
