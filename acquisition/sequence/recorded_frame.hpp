// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "proto/model/fan_geometry.hpp"
#include "proto/model/frame.hpp"

namespace fanlight {

/// A frame of a recording, without its pixels, as its source gave it.
struct RecordedFrame {
  FrameStamp stamp;
  FrameFault fault = FrameFault::kNone;  ///< else its pixels are 0

  bool usable() const { return fault == FrameFault::kNone; }
};

/// What all frames of a recording share: with the frames, all that a replay needs to act like the source.
struct RecordingFacts {
  std::string source;  ///< SourceDescription::name, printable, one line
  FanGeometry geometry;
  bool counts_volumes = true;  ///< the rest as in SourceDescription
  std::uint32_t frames_per_volume = 0;
  std::uint32_t usual_frames = 0;
  bool simulated = false;
  double first_angle_rad = 0;
  double last_angle_rad = 0;
  std::int64_t begun_utc_s = 0;  ///< when the first frame was recorded, seconds since 1970

  bool operator==(const RecordingFacts&) const = default;
};

}  // namespace fanlight
