// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "proto/exchange/small_queue.hpp"

namespace fanlight {

/// A sweep that the assembler gave no volume for.
struct DroppedSweep {
  enum class Reason : std::uint8_t {
    kMissing,  ///< too many frames are missing
    kRun,      ///< too many in a row
    kGap,      ///< the angle jumps between two frames
    kCutOff,   ///< it began or ended in its middle
    kStill,    ///< the angle did not move
  };
  std::uint64_t volume_index = 0;  ///< the source's own number
  Reason reason = Reason::kMissing;
  std::uint32_t frames = 0;   ///< usable ones
  std::uint64_t missing = 0;  ///< never received, or not usable
  std::uint64_t longest_run = 0;
  double gap_deg = 0;
  double usual_step_deg = 0;
};

/// Why it was dropped: "30 of 74 frames are missing, expected 15 % at most".
std::string reason_of(const DroppedSweep& sweep);

/// Dropped sweeps on their way from the acquisition thread to one reader. Beyond the capacity further ones
/// are forgotten.
using DroppedSweeps = SmallQueue<DroppedSweep, 256>;

}  // namespace fanlight
