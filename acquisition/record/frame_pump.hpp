// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stop_token>

#include "acquisition/source/frame_source.hpp"
#include "proto/exchange/frame_tap.hpp"

namespace fanlight {

/// Where a frame finds no room in the tap's queue.
enum class FullQueue : std::uint8_t {
  kLoseFrame,  ///< a probe does not wait
  kWait,       ///< a source without a pace of its own does
};

/// Passes all frames of a source to a tap, until the source ends or a stop is requested. Nothing is assembled
/// or rendered. Blocks; the thread of the source. Errors: the source's.
Result<void> pump_frames(FrameSource& source, FrameTap& tap, FullQueue full, const std::stop_token& stop);

}  // namespace fanlight
