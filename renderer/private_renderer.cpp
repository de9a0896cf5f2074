// SPDX-License-Identifier: Apache-2.0
#include "renderer/private_renderer.hpp"

#include <algorithm>
#include <utility>

#include "proto/base/clock.hpp"

namespace fanlight {

Result<void> PrivateRenderer::want(const PrivateViews& views) {
  thread_owner_.check();
  for (std::size_t index = 0; index < views.size(); ++index) {
    ViewState& state = states_[index];
    // A new view counts its pictures from 1. collect() drops work under way for the view before.
    if (state.wanted.view_id != views[index].view_id) {
      state.drawn = false;
      state.pictures = 0;
    }
    state.wanted = views[index];
    const PrivateViewEnd& last_end = ends_[index];
    const bool ended =
        state.wanted.view_id == last_end.view_id && state.wanted.scene.revision <= last_end.revision;
    if (ended) state.wanted.view_id = 0;
    if (state.wanted.view_id == 0) continue;
    auto created = create_passes(state);
    if (created) continue;
    if (created.error().code == ErrorCode::kLost) return created;
    end(state, created.error());
  }
  return {};
}

LightPass::Config PrivateRenderer::light_config(PictureSize largest) const {
  return {.largest = largest,
          .copies = LightPass::Config::Copies::kOnDevice,
          .pauses = true,
          .workers = cast_config_.ray_workers};
}

/// Creates the passes that the wanted view needs and does not have.
Result<void> PrivateRenderer::create_passes(ViewState& state) const {
  if (!state.light) {
    auto light = LightPass::create(device_, light_config(cast_config_.size));
    if (!light) return light.error();
    state.light = std::move(*light);
  }
  if (state.wanted.own_camera && !state.cast) {
    auto cast = CastPass::create(device_, cast_config_);
    if (!cast) return cast.error();
    state.cast = std::move(*cast);
  }
  return {};
}

void PrivateRenderer::drop_passes(ViewState& state) {
  state.light.reset();
  state.cast.reset();
}

void PrivateRenderer::end(ViewState& state, const Error& error) {
  ends_[static_cast<std::size_t>(&state - states_.data())] = {.view_id = state.wanted.view_id,
                                                              .revision = state.wanted.scene.revision,
                                                              .reason = std::string_view(error.message)};
  ends_changed_ = true;
  counters_.private_views_refused.add();
  // Half of its work may be recorded: the next view of this index gets memory of its own. But what the GPU
  // uses stays, where a piece before the failure is outstanding.
  if (state.outstanding() == 0) {
    drop_passes(state);
    state.slot = nullptr;
  }
  state.phase = WorkPhase::kIdle;
  state.drawn = false;
  state.wanted.view_id = 0;
}

PrivateRenderer::Progress PrivateRenderer::progress() const {
  Progress progress{.ends = ends_};
  for (std::size_t index = 0; index < states_.size(); ++index) {
    progress.views[index] = {.view_id = states_[index].wanted.view_id, .pictures = states_[index].pictures};
  }
  return progress;
}

void PrivateRenderer::resume(const Progress& progress) {
  ends_ = progress.ends;
  for (std::size_t index = 0; index < states_.size(); ++index) {
    states_[index].wanted.view_id = progress.views[index].view_id;
    states_[index].pictures = progress.views[index].pictures;
  }
}

Result<void> PrivateRenderer::retry_held() {
  for (ViewState& state : states_) {
    Result<void> retried;
    if (state.cast) retried = state.cast->recorder().retry_held();
    if (retried && state.light) retried = state.light->recorder().retry_held();
    if (retried) continue;
    if (retried.error().code == ErrorCode::kLost) return retried;
    end(state, retried.error());
  }
  return {};
}

void PrivateRenderer::drop_held() {
  for (ViewState& state : states_) {
    if (state.cast) state.cast->drop_held();
    if (state.light) state.light->recorder().drop_held();
  }
}

void PrivateRenderer::leave_memory() {
  for (ViewState& state : states_) {
    if (state.cast) static_cast<void>(new CastPass(std::move(*state.cast)));
    if (state.light) static_cast<void>(new LightPass(std::move(*state.light)));
  }
}

/// Whether the main view has replaced the frames that the next pieces of the picture read, or the memory that
/// their descriptors name.
bool PrivateRenderer::inputs_lost(const ViewState& state) {
  if (state.slot == nullptr || !state.light) return false;
  const VolumeInFlight& slot = *state.slot;
  if (state.bindings_version != slot.bindings_version()) return true;  // frames of another size
  // The first piece of passes 2 and 3, which was submitted as they began, has copied the main view's map, and
  // read the earlier one.
  if (state.phase == WorkPhase::kLighting) return false;
  return state.frames_version != slot.frames_version() || !slot.frames_ready();
}

std::array<PrivateStatus, kMostPrivateViews> PrivateRenderer::status(const Shown& shown) const {
  std::array<PrivateStatus, kMostPrivateViews> all;
  for (std::size_t index = 0; index < all.size(); ++index) {
    const ViewState& state = states_[index];
    all[index] = {.phase = state.phase,
                  .wanted_view_id = state.light ? state.wanted.view_id : 0,
                  .wanted_revision = state.wanted.scene.revision,
                  .own_camera = state.wanted.own_camera,
                  .wanted_scene = &state.wanted.scene.scene,
                  .view_id = state.stamp.view_id,
                  .revision = state.revision,
                  .volume_id = state.stamp.volume.volume_id,
                  .frames_version = state.frames_version,
                  .cast_number = state.cast_number,
                  .scene = &state.scene,
                  .of_shown_slot = state.slot == &shown.slot,
                  .drawn = state.drawn,
                  .cast_submitted = state.cast && state.cast->submitted(),
                  .light_submitted = state.light && state.light->steps().submitted(),
                  .inputs_lost = inputs_lost(state)};
  }
  return all;
}

std::optional<PrivateAction> PrivateRenderer::next_action(const Shown& shown) const {
  return decide(status(shown), next_,
                {.frames_ready = shown.slot.frames_ready(),
                 .volume_id = shown.slot.volume().volume_id,
                 .frames_version = shown.slot.frames_version(),
                 .cast_number = shown.cast_number});
}

bool PrivateRenderer::due(const Shown& shown) const {
  return busy() || next_action(shown).has_value();
}

Result<bool> PrivateRenderer::advance(const Shown& shown) {
  thread_owner_.check();
  const auto action = next_action(shown);
  if (!action) return false;
  ViewState& state = states_[action->view];
  next_ = action->next_view;
  if (action->gives_up) {
    (state.phase == WorkPhase::kCasting ? counters_.private_casts_given_up
                                        : counters_.private_lights_given_up)
        .add();
    state.phase = WorkPhase::kIdle;
    state.drawn = false;
  }
  if (auto done = execute(action->step, state, shown); !done) {
    if (done.error().code == ErrorCode::kLost) return done.error();
    end(state, done.error());
  }
  return true;
}

Result<void> PrivateRenderer::execute(PrivateStep step, ViewState& state, const Shown& shown) {
  switch (step) {
    case PrivateStep::kDrop:
      return {};
    case PrivateStep::kRelight:
    case PrivateStep::kLightShared:
      take_request(state, shown);
      return light(state, shown);
    case PrivateStep::kBeginCast:
      take_request(state, shown);
      return begin_cast(state, shown);
    case PrivateStep::kCastBand:
      return state.cast->submit_next(state.slot->bindings());
    case PrivateStep::kLightCast:
      return light(state, shown);
    case PrivateStep::kLightPiece:
      return state.light->submit_next();
  }
  return {};
}

void PrivateRenderer::take_request(ViewState& state, const Shown& shown) {
  state.slot = &shown.slot;
  state.frames_version = shown.slot.frames_version();
  state.bindings_version = shown.slot.bindings_version();
  state.revision = state.wanted.scene.revision;
  state.stamp = {.view_id = state.wanted.view_id,
                 .scene_revision = state.revision,
                 .pass1_runs = counters_.pass1_runs.value(),
                 .pass2_runs = counters_.pass2_runs.value(),
                 .volume = shown.slot.volume(),
                 .levels = shown.slot.levels()};
  state.scene = requested_scene(state, shown);
  state.stamp.near_tissue = shown.slot.near_tissue_state(state.scene);
  state.stamp.near_end_mm = shown.slot.near_end_mm(state.scene);
  state.stamp.sample_distances = shown.slot.sample_distances(state.scene);
  state.cast_number = state.wanted.own_camera ? 0 : shown.cast_number;
}

Scene PrivateRenderer::requested_scene(const ViewState& state, const Shown& shown) {
  const Scene& wanted = state.wanted.scene.scene;
  return state.wanted.own_camera ? wanted : relit(shown.cast_scene, wanted);
}

Result<void> PrivateRenderer::begin_cast(ViewState& state, const Shown& shown) {
  CastPass& cast = *state.cast;
  cast.bind(shown.slot.bindings());
  if (auto begun = cast.begin(state.scene, shown.slot.bindings()); !begun) return begun;
  state.phase = WorkPhase::kCasting;
  counters_.private_casts.add();
  return cast.submit_next(shown.slot.bindings());
}

/// Submits the weights of the depth filter where they are due.
Result<void> PrivateRenderer::add_weights(ViewState& state) {
  VolumeInFlight& slot = *state.slot;
  if (state.casts()) {
    if (!state.cast->weights_due(state.scene, slot.bindings())) return {};
    auto added = state.cast->add_weights(state.scene, slot.bindings());
    state.cast->drop_held_weights();
    return added;
  }
  if (!slot.weights_due(state.scene)) return {};
  auto added = slot.add_weights(state.scene);
  slot.drop_held_weights();
  return added;
}

/// Makes room for the main view's maps, which may be finer now.
Result<void> PrivateRenderer::fit_light(ViewState& state, PictureSize size) const {
  if (size.pixels() <= state.light->largest().pixels()) return {};
  state.light.reset();  // frees its memory first
  auto light = LightPass::create(device_, light_config(size));
  if (!light) return light.error();
  state.light = std::move(*light);
  return {};
}

/// A view with its own camera is averaged with what the main view shows of the volume.
LightPass::Earlier PrivateRenderer::earlier_of(const ViewState& state, const Shown& shown) {
  if (!state.casts()) return shown.earlier;
  return earlier_map(shown.cast_scene, shown.usual_size, state.scene, true);
}

/// Submits the first piece of passes 2 and 3, and before it the weights that it needs.
Result<void> PrivateRenderer::light(ViewState& state, const Shown& shown) {
  VolumeInFlight& slot = *state.slot;
  const PictureSize size = size_of(state.scene, cast_config_.size);
  if (auto fits = fit_light(state, size); !fits) return fits;
  LightPass& light = *state.light;
  if (auto added = add_weights(state); !added) return added;
  if (state.casts()) {
    light.read(*state.cast);
  } else {
    light.copy(slot.cast());
  }
  const LightPass::Earlier earlier = earlier_of(state, shown);
  if (earlier) light.follow((state.casts() ? shown.slot : shown.previous).steady_for_private_views());
  state.phase = WorkPhase::kLighting;
  state.stamp.view = picture_view(state.scene, size);
  if (auto begun = light.begin(slot.effective(state.scene), earlier); !begun) return begun;
  return light.submit_next();
}

std::array<double, kStages> PrivateRenderer::stage_ms(const ViewState& state) {
  auto ms = state.light->stage_ms();
  if (!state.casts() || !state.light->is_first_of_cast()) return ms;
  const auto cast_ms = state.cast->recorder().stage_ms();
  for (std::size_t stage = 0; stage < kStages; ++stage) ms[stage] += cast_ms[stage];
  return ms;
}

bool PrivateRenderer::collect() {
  thread_owner_.check();
  bool any = false;
  for (ViewState& state : states_) {
    if (!state.awaits_collection() || state.outstanding() > 0) continue;
    const auto stage_ms = this->stage_ms(state);
    if (device_.gpu->fault() != nullptr)
      return false;  // what a lost GPU has left in the memory may be an old picture
    state.phase = WorkPhase::kIdle;
    state.drawn = state.wanted.view_id == state.stamp.view_id;
    if (!state.drawn) continue;
    state.stamp.picture_id = ++state.pictures;
    state.stamp.stage_ms = stage_ms;
    state.stamp.finished_time_ns = now_ns();
    Picture& picture = state.wanted.pictures->draft();
    state.light->read_picture(state.stamp, picture);
    state.wanted.pictures->publish();
    counters_.private_pictures.add();
    any = true;
  }
  return any;
}

std::array<const SubmissionTimeline*, 2> PrivateRenderer::timelines(std::size_t index) const {
  const ViewState& state = states_[index];
  return {state.cast ? &state.cast->recorder().timeline() : nullptr,
          state.light ? &state.light->recorder().timeline() : nullptr};
}

const SubmissionTimeline* PrivateRenderer::outstanding_timeline() const {
  for (std::size_t index = 0; index < states_.size(); ++index) {
    for (const SubmissionTimeline* const timeline : timelines(index)) {
      if (timeline != nullptr && timeline->outstanding() > 0) return timeline;
    }
  }
  return nullptr;
}

bool PrivateRenderer::busy() const {
  return std::ranges::any_of(
      states_, [](const ViewState& state) { return state.awaits_collection() || state.outstanding() > 0; });
}

bool PrivateRenderer::reads(const VolumeInFlight& slot) const {
  return std::ranges::any_of(
      states_, [&](const ViewState& state) { return state.slot == &slot && state.outstanding() > 0; });
}

}  // namespace fanlight
