// SPDX-License-Identifier: Apache-2.0
// Renderer: passes 2 and 3 of the main view.
#include "renderer/renderer.hpp"

namespace fanlight {

VolumeInFlight::History Renderer::history_of(const SlotState& state) const {
  using History = VolumeInFlight::History;
  if (replaces_frames()) return History::kNone;  // a single slot is used, and it keeps no last volume
  const SlotState& other = &state == slots_[0].get() ? *slots_[1] : *slots_[0];
  // The cine goes in any direction, and each of its volumes has one picture whatever was shown before.
  if (state.is_kept || other.is_kept) return History::kNone;
  const bool before =
      other.filtered_volume_id > 0 && other.filtered_volume_id < state.slot.volume().volume_id;
  const bool same_view =
      before && first_pass_changed(other.filtered_view, state.cast_scene.scene) > FirstPass::kCast;
  return same_view ? History::kUsable : History::kNone;
}

Result<void> Renderer::light(SlotState& state) {
  // The shown volume goes without weights where another one is cast, whose picture will have them.
  const bool takes_time = state.phase == WorkPhase::kCasting || &state == slots_[newest_].get();
  const Scene scene = relit(state.cast_scene.scene, scene_.scene);
  if (!takes_time || !state.slot.weights_due(scene) || state.slot.outstanding() > 0)
    return submit_light(state);
  // A private view still reads the weights that this would overwrite: the next call tries again.
  if (private_.reads(state.slot)) return {};
  if (auto added = state.slot.add_weights(scene); !added)
    return falls_back(added.error()) ? Result<void>{} : added;
  state.phase = WorkPhase::kCasting;  // the light follows when this is done
  return {};
}

void Renderer::take_light_scene(SlotState& state) const {
  state.lit_scene = {
      .revision = view_changed(state.cast_scene, scene_) ? state.cast_scene.revision : scene_.revision,
      .scene = relit(state.cast_scene.scene, scene_.scene)};
}

Result<void> Renderer::submit_light_piece(SlotState& state) {
  const Scene now = relit(state.cast_scene.scene, scene_.scene);
  const bool same_filter = first_pass_changed(state.lit_scene.scene, now) > FirstPass::kFilter;
  const SlotStatus status{.cast_scene = &state.cast_scene, .lit_scene = &state.lit_scene};
  // The picture has no light yet: it gets the newest one. Another filter waits for the next picture: one that
  // never rests would begin this one again and again.
  if (state.slot.light_begun() || !same_filter || !light_changed(status, scene_))
    return state.slot.light_next_piece(nullptr);
  const NumberedScene before = state.lit_scene;
  take_light_scene(state);
  auto lit = state.slot.light_next_piece(&state.lit_scene.scene);
  if (!lit && falls_back(lit.error())) {
    state.lit_scene = before;
    return state.slot.light_next_piece(&state.lit_scene.scene);
  }
  if (!lit) return lit;
  note_light(state);
  return {};
}

Result<void> Renderer::submit_light(SlotState& state) {
  take_light_scene(state);
  if (auto lit = state.slot.light(state.lit_scene.scene, history_of(state)); !lit) {
    // The next advance() lights it by the scene that is in force then.
    return falls_back(lit.error()) ? Result<void>{} : lit;
  }
  state.filtered_volume_id = state.slot.volume().volume_id;
  state.filtered_view = state.cast_scene.scene;
  state.phase = WorkPhase::kLighting;
  state.gave_up_cast = false;
  counters_.pass2_runs.add();
  if (state.slot.lights_a_part()) counters_.pass2_parts.add();
  note_light(state);
  return {};
}

/// Notes what the picture will show: lit_scene, by the scene in force.
void Renderer::note_light(SlotState& state) {
  proven_ = scene_;
  if (scene_.revision == wanted_.revision) scene_refusal_.clear();
  state.stamp = {.scene_revision = state.lit_scene.revision,
                 .pass1_runs = counters_.pass1_runs.value(),
                 .pass2_runs = counters_.pass2_runs.value(),
                 .deadline_level = scene_.deadline.level,
                 .measures = state.cast_scene.deadline.measures,
                 .volume = state.slot.volume(),
                 .levels = state.slot.levels(),
                 .view = picture_view(state.cast_scene.scene, config_.size)};
  state.stamp.measures.cheap_filters = scene_.deadline.measures.cheap_filters;
}

}  // namespace fanlight
