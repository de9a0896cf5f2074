// SPDX-License-Identifier: Apache-2.0
#include "acquisition/assembly/dropped_sweeps.hpp"

#include <fmt/format.h>

namespace fanlight {

std::string reason_of(const DroppedSweep& sweep) {
  using Reason = DroppedSweep::Reason;
  switch (sweep.reason) {
    case Reason::kMissing:
      return fmt::format("{} of its {} frames are missing or not usable, expected 15 % at most",
                         sweep.missing, sweep.frames + sweep.missing);
    case Reason::kRun:
      return fmt::format("{} frames in a row are missing or not usable, expected 3 at most",
                         sweep.longest_run);
    case Reason::kGap:
      return fmt::format(
          "its angle jumps by {:.2f} deg between two frames, expected at most five usual steps of {:.2f} "
          "deg",
          sweep.gap_deg, sweep.usual_step_deg);
    case Reason::kCutOff:
      return fmt::format("it began or ended in its middle, with {} frames", sweep.frames);
    case Reason::kStill:
      return fmt::format("the angle of its {} frames does not move, expected a sweep", sweep.frames);
  }
  return {};
}

}  // namespace fanlight
