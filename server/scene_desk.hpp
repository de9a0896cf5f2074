#pragma once

#include <cstdint>

#include "proto/fanlight.pb.h"
#include "proto/mailbox.hpp"
#include "proto/picture.hpp"
#include "proto/result.hpp"

namespace fanlight {

/// Where the scene in force is kept, and where changes of it are checked, numbered and handed to the render
/// thread. Server thread only.
class SceneDesk {
 public:
  /// `initial` is what the renderer was made with, `suggested` what it would have been had nobody asked for
  /// anything; `scenes` must outlive the desk.
  SceneDesk(const NumberedScene& initial, const Scene& suggested, Mailbox<NumberedScene>& scenes)
      : suggested_(suggested), default_(initial.scene), in_force_(initial), scenes_(scenes) {}

  const NumberedScene& in_force() const { return in_force_; }
  const Scene& default_scene() const { return default_; }

  /// Takes all of the change or, with an Error, none of it. True where the scene is another one now; a change
  /// that changes nothing keeps the revision. `refused`: as in changed_scene().
  Result<bool> apply(const v1::Scene& change, const SceneField** refused = nullptr);

  /// The source looks elsewhere now, and this would be the scene for it if nobody had asked for anything.
  /// What is still as it was suggested for the last one follows, in the default and in the scene in force;
  /// what somebody chose stays. True where either is another one now.
  bool suggest(const Scene& suggested);

 private:
  Scene suggested_;
  Scene default_;
  NumberedScene in_force_;
  Mailbox<NumberedScene>& scenes_;
};

/// The scene in force as a message.
v1::SceneState scene_state(const NumberedScene& scene);

}  // namespace fanlight
