// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "proto/model/scene.hpp"
#include "renderer/schedule/work_phase.hpp"

namespace fanlight {

// The order of the private views' work, without a GPU: pure functions of a snapshot. None of them allocates
// or blocks.

/// Snapshot of what the main view shows.
struct ShownStatus {
  bool frames_ready = false;  ///< the frames that rays sample are those of the main view's cast
  std::uint64_t volume_id = 0;
  std::uint64_t frames_version = 0;  ///< changes with the frames
  std::uint64_t cast_number = 0;     ///< of the depth map, from 1
};

/// Snapshot of one private view: what is requested of it, and what it drew last or is drawing.
struct PrivateStatus {
  WorkPhase phase = WorkPhase::kIdle;

  std::uint64_t wanted_view_id = 0;  ///< 0: no view is requested
  std::uint64_t wanted_revision = 0;
  bool own_camera = false;              ///< casts its own rays
  const Scene* wanted_scene = nullptr;  ///< not null

  std::uint64_t view_id = 0;
  std::uint64_t revision = 0;
  std::uint64_t volume_id = 0;
  std::uint64_t frames_version = 0;
  std::uint64_t cast_number = 0;  ///< of the main view's depth map that it uses; 0: its own
  const Scene* scene = nullptr;   ///< not null
  bool of_shown_slot = false;     ///< that work reads the slot that the main view shows
  bool drawn = false;             ///< there was a picture since the view was opened
  bool cast_submitted = false;
  bool light_submitted = false;  ///< all of passes 2 and 3
  bool inputs_lost = false;      ///< what its next piece reads was replaced
};

enum class PrivateStep : std::uint8_t {
  kDrop,         ///< forget the picture under way; no view is requested any more
  kRelight,      ///< begin passes 2 and 3 for a depth map that the view used before, its own or a shared one
  kLightShared,  ///< copy the main view's depth map and begin passes 2 and 3
  kBeginCast,    ///< begin a cast of its own and submit its first band
  kCastBand,     ///< submit the next band
  kLightCast,    ///< begin passes 2 and 3 of the finished cast
  kLightPiece    ///< submit the next piece of passes 2 and 3
};

/// One piece of work of a private view.
struct PrivateAction {
  std::size_t view = 0;
  PrivateStep step = PrivateStep::kDrop;
  bool gives_up = false;      ///< the picture under way is given up before the step
  std::size_t next_view = 0;  ///< the view that decide() examines first next time
};

/// The piece of work that is due; nothing where no view has one. A picture under way continues before another
/// one begins: the time until its frames are replaced may suffice for one picture only. Otherwise the first
/// view from `first_view` on that has work: views take turns. Precondition: nothing of the main view and of
/// the private views is outstanding.
std::optional<PrivateAction> decide(std::span<const PrivateStatus> views, std::size_t first_view,
                                    const ShownStatus& shown);

}  // namespace fanlight
