// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <utility>
#include <vector>

#include "proto/base/result.hpp"
#include "proto/base/thread_owner.hpp"
#include "proto/exchange/mailbox.hpp"
#include "proto/fanlight.pb.h"
#include "proto/model/scene.hpp"

namespace fanlight {

/// Keeps the scene in force. Checks and numbers its changes and passes them to the render thread. Server
/// thread only.
class SceneStore {
 public:
  /// `initial`: the scene that the renderer was made with. `suggested`: the scene for the source alone,
  /// without options of the user. `chosen`: the fields that the user gave options for. `scenes` must outlive
  /// this object.
  SceneStore(const NumberedScene& initial, const Scene& suggested, Mailbox<NumberedScene>& scenes,
             std::vector<const SceneField*> chosen = {})
      : suggested_(suggested),
        default_(initial.scene),
        in_force_(initial),
        shown_(initial),
        scenes_(scenes),
        chosen_(std::move(chosen)) {}

  const NumberedScene& in_force() const { return in_force_; }
  /// One of the last scenes, by its revision; nullptr for an older one.
  const Scene* of_revision(std::uint64_t revision) const;
  const Scene& default_scene() const { return default_; }
  const Scene& suggested() const { return suggested_; }

  /// Applies all of the change or, with an Error, nothing. True if the scene differs now; otherwise the
  /// revision stays. `refused`: as in changed_scene().
  Result<bool> apply(const v1::Scene& change, const SceneField** refused = nullptr);

  /// The geometry of the source has changed; `suggested` is the scene for it alone. Fields that still have
  /// the value of the last suggestion take the new one, in the default scene and in the scene in force;
  /// fields that were chosen otherwise, or by an option, stay. True if either scene differs now. Error: what
  /// was chosen contradicts the suggestion; nothing changes.
  Result<bool> suggest(const Scene& suggested);

  /// The newest picture shows this revision.
  void note_shown(std::uint64_t revision);
  std::uint64_t shown_revision() const { return shown_.revision; }
  /// Puts the scene of the newest picture in force again, under a new revision.
  void return_to_shown();

 private:
  void put_in_force(const Scene& scene);

  Scene suggested_;
  Scene default_;
  NumberedScene in_force_;
  NumberedScene shown_;
  std::deque<NumberedScene> earlier_;  // a picture may show one of them
  Mailbox<NumberedScene>& scenes_;
  std::vector<const SceneField*> chosen_;
  [[no_unique_address]] ThreadOwner thread_owner_;
};

/// The scene in force as a message.
v1::SceneState scene_state(const NumberedScene& scene);

}  // namespace fanlight
