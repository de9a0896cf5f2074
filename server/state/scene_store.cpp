// SPDX-License-Identifier: Apache-2.0
#include "server/state/scene_store.hpp"

#include <algorithm>

#include "server/state/scene_message.hpp"

namespace fanlight {

Result<bool> SceneStore::apply(const v1::Scene& change, const SceneField** refused) {
  thread_owner_.check();
  auto changed = changed_scene(in_force_.scene, change, refused);
  if (!changed) return changed.error();
  if (first_pass_changed(in_force_.scene, *changed) == FirstPass::kNone) return false;
  put_in_force(*changed);
  return true;
}

void SceneStore::put_in_force(const Scene& scene) {
  constexpr std::size_t kMostEarlier = 256;
  earlier_.push_back(in_force_);
  if (earlier_.size() > kMostEarlier) earlier_.pop_front();
  in_force_ = {.revision = in_force_.revision + 1, .scene = scene};
  scenes_.draft() = in_force_;
  scenes_.publish();
}

const Scene* SceneStore::of_revision(std::uint64_t revision) const {
  if (in_force_.revision == revision) return &in_force_.scene;
  const auto found = std::ranges::find(earlier_, revision, &NumberedScene::revision);
  return found == earlier_.end() ? nullptr : &found->scene;
}

void SceneStore::note_shown(std::uint64_t revision) {
  // The light of an older cast has the older revision.
  if (revision <= shown_.revision) return;
  shown_.revision = revision;
  if (const Scene* const scene = of_revision(revision); scene != nullptr) shown_.scene = *scene;
}

void SceneStore::return_to_shown() {
  thread_owner_.check();
  put_in_force(shown_.scene);
}

Result<bool> SceneStore::suggest(const Scene& suggested) {
  thread_owner_.check();
  Scene default_scene = default_;
  Scene scene = in_force_.scene;
  for (const SceneField& field : scene_fields()) {
    if (std::ranges::find(chosen_, &field) != chosen_.end()) continue;
    if (field.same(default_scene, suggested_)) field.copy(default_scene, suggested);
    if (field.same(scene, suggested_)) field.copy(scene, suggested);
  }
  // Chosen fields may contradict the new ones, for example if a ray would end before it starts.
  for (const Scene* each : {&default_scene, &scene}) {
    if (auto whole = check(*each); !whole) return whole.error();
  }
  suggested_ = suggested;
  const bool other_default = first_pass_changed(default_, default_scene) != FirstPass::kNone;
  const bool other_scene = first_pass_changed(in_force_.scene, scene) != FirstPass::kNone;
  default_ = default_scene;
  if (other_scene) put_in_force(scene);
  return other_default || other_scene;
}

v1::SceneState scene_state(const NumberedScene& scene) {
  v1::SceneState state;
  state.set_revision(scene.revision);
  *state.mutable_scene() = scene_message(scene.scene);
  return state;
}

}  // namespace fanlight
