#include "server/scene_desk.hpp"

#include "server/scene_message.hpp"

namespace fanlight {

Result<bool> SceneDesk::apply(const v1::Scene& change) {
  auto changed = changed_scene(in_force_.scene, change);
  if (!changed) return changed.error();
  if (first_pass_changed(in_force_.scene, *changed) == FirstPass::kNone) return false;
  in_force_ = {.revision = in_force_.revision + 1, .scene = *changed};
  scenes_.draft() = in_force_;
  scenes_.publish();
  return true;
}

v1::SceneState scene_state(const NumberedScene& scene) {
  v1::SceneState state;
  state.set_revision(scene.revision);
  *state.mutable_scene() = scene_message(scene.scene);
  return state;
}

}  // namespace fanlight
