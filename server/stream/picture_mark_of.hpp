// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "server/codec/picture_mark.hpp"
#include "server/state/picture_liveness.hpp"

namespace fanlight {

/// The words for a picture that is seen without a page around it.
inline PictureMark mark_of(const PictureLiveness::Report& report) {
  using State = PictureLiveness::State;
  switch (report.state) {
    case State::kLive:
      return report.origin == FrameOrigin::kSimulated ? PictureMark::kSimulated : PictureMark::kNone;
    case State::kDelayed:
      return PictureMark::kDelayed;
    case State::kReplay:
      return PictureMark::kReplay;
    case State::kFrozen:
      return PictureMark::kFrozen;
    case State::kWaiting:
    case State::kNotLive:
    case State::kResting:
      break;
  }
  return PictureMark::kNotLive;
}

}  // namespace fanlight
