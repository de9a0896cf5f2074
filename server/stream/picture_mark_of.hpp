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

/// Where the frames come from, in the header of a picture: "probe", "unknown", "simulated" or "recording".
inline const char* origin_name(FrameOrigin origin) {
  switch (origin) {
    case FrameOrigin::kProbe:
      return "probe";
    case FrameOrigin::kSimulated:
      return "simulated";
    case FrameOrigin::kRecording:
      return "recording";
    case FrameOrigin::kUnknown:
      break;
  }
  return "unknown";
}

}  // namespace fanlight
