// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "proto/exchange/doorbell.hpp"
#include "proto/exchange/mailbox.hpp"
#include "proto/exchange/small_queue.hpp"

namespace fanlight {

/// What follows the last frame of a recording that is played.
enum class ReplayEnding : std::uint8_t {
  kOnce,     ///< nothing
  kLoop,     ///< its first frame, again and again
  kToAndFro  ///< the frames backward, then forward again, like a motor: a single sweep gives both directions
};

/// What the player of a recording is asked for.
struct ReplayOrder {
  enum class Wish : std::uint8_t {
    kPlay,    ///< continues; after the last frame, or one that could not be read: from the first one
    kPause,   ///< at once, also within a sweep
    kStep,    ///< plays `sweeps` further, then pauses; negative: that many sweeps back
    kSeek,    ///< continues with the sweep at `time_s`; where it is paused, plays that sweep and pauses
    kFrame,   ///< plays the sweep of the frame with this `number`, then pauses
    kSpeed,   ///< continues with `speed`
    kEnding,  ///< changes what follows the last frame
  };
  Wish wish = Wish::kPlay;
  std::int32_t sweeps = 1;
  std::uint64_t number = 0;  ///< FrameStamp::number_in_recording(); none has it: the next one that there is
  double time_s = 0;         ///< since the first frame; beyond the recording: its nearer end
  double speed = 1;          ///< kLeastReplaySpeed to kMostReplaySpeed
  ReplayEnding ending = ReplayEnding::kOnce;
};

inline constexpr double kLeastReplaySpeed = 0.01;
inline constexpr double kMostReplaySpeed = 1000;

/// State of the player of a recording.
struct ReplayStatus {
  enum class State : std::uint8_t {
    kAbsent,   ///< the source is no recording
    kPlaying,  ///< also while it plays the sweeps of a step
    kPaused,
    kEnded,   ///< behind the last frame
    kFailed,  ///< a frame could not be read; other parts of the recording may still be played
  };
  /// What became of the recording's file while it was played.
  enum class File : std::uint8_t { kSame, kChanged, kRemoved };
  State state = State::kAbsent;
  bool backward = false;          ///< this pass, of kToAndFro
  bool can_play_backward = true;  ///< else kToAndFro would read the file again for each frame
  ReplayEnding ending = ReplayEnding::kOnce;
  File file = File::kSame;
  std::uint32_t sweep = 0;  ///< of the last frame, from 0
  std::uint32_t sweeps = 0;
  double time_s = 0;  ///< of the last frame, since the first one
  double duration_s = 0;
  double speed = 1;
  std::string trouble;  ///< why it has failed; else empty
};

/// Orders on their way from the server thread to the acquisition thread, which plays a recording, and the
/// player's state on its way back.
struct ReplayLink {
  /// `server_bell` must outlive the link; it rings with each status.
  explicit ReplayLink(Doorbell& server_bell) : status(server_bell) {}

  /// Server thread. False where too many orders wait.
  bool send(const ReplayOrder& order) {
    const bool put = orders.put(order);
    player_bell.ring();
    return put;
  }

  SmallQueue<ReplayOrder, 16> orders;
  Doorbell player_bell;  ///< wakes the player
  Mailbox<ReplayStatus> status;
};

}  // namespace fanlight
