// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace fanlight {

/// What the display of the last volumes (the cine) is asked for.
struct CineOrder {
  enum class Wish : std::uint8_t {
    kFreeze,  ///< keeps the last volumes, and shows `volume_id`
    kLive,    ///< lets them go, and shows new volumes again
    kPlay,    ///< shows the kept volumes one after the other, in a loop
    kPause,
    kStep,   ///< pauses, `volumes` further; negative: back; beyond an end: from the other end
    kSeek,   ///< pauses at `volume`
    kSpeed,  ///< plays with `speed`
  };
  Wish wish = Wish::kFreeze;
  std::int32_t volumes = 1;
  std::uint32_t volume = 0;     ///< from 0, the oldest; beyond the newest: the newest
  std::uint64_t volume_id = 0;  ///< kFreeze: the volume that the user sees; one that is not kept: the newest
  double speed = 1;             ///< kLeastCineSpeed to kMostCineSpeed; 1 as captured
};

inline constexpr double kLeastCineSpeed = 0.1;
inline constexpr double kMostCineSpeed = 4;

/// What is on show: new volumes, or which of the kept ones.
struct CineStatus {
  enum class State : std::uint8_t {
    kLive,    ///< new volumes are shown as they come
    kFrozen,  ///< one of the kept volumes is shown
    kPlaying  ///< the kept volumes are shown one after the other
  };
  State state = State::kLive;
  std::uint32_t capacity = 0;  ///< most volumes that can be kept, besides the one on show
  std::uint32_t volumes = 0;   ///< kept now, with the one on show at the freeze
  std::uint32_t volume = 0;    ///< on show, from 0, the oldest
  double time_s = 0;           ///< of the volume on show, since the oldest one
  double duration_s = 0;       ///< from the oldest to the newest
  double speed = 1;
  std::uint64_t volume_id = 0;  ///< of the volume on show; 0 while live

  bool operator==(const CineStatus&) const = default;
};

}  // namespace fanlight
