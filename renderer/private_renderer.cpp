// SPDX-License-Identifier: Apache-2.0
#include "renderer/private_renderer.hpp"

#include <algorithm>
#include <utility>

#include "proto/base/clock.hpp"

namespace fanlight {

Result<void> PrivateRenderer::want(const PrivateViews& views) {
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
    if (state.wanted.view_id == 0 || state.view) continue;
    auto view = ViewRenderer::create(device_, view_config_);
    if (view) {
      state.view = std::move(*view);
    } else if (view.error().code == ErrorCode::kLost) {
      return view.error();
    } else {
      end(state, view.error());
    }
  }
  return {};
}

void PrivateRenderer::end(ViewState& state, const Error& error) {
  ends_[static_cast<std::size_t>(&state - states_.data())] = {.view_id = state.wanted.view_id,
                                                              .revision = state.wanted.scene.revision,
                                                              .reason = std::string_view(error.message)};
  ends_changed_ = true;
  counters_.private_views_refused.add();
  // Half of its work may be recorded: the next view of this index gets memory of its own. Nothing of this one
  // is outstanding, since it failed before it was submitted.
  state.view.reset();
  state.slot = nullptr;
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
    if (!state.view) continue;
    auto retried = state.view->retry_held();
    if (retried) continue;
    if (retried.error().code == ErrorCode::kLost) return retried;
    end(state, retried.error());
  }
  return {};
}

void PrivateRenderer::drop_held() {
  for (ViewState& state : states_) {
    if (state.view) state.view->drop_held();
  }
}

void PrivateRenderer::leave_memory() {
  for (ViewState& state : states_) {
    if (state.view) static_cast<void>(new ViewRenderer(std::move(*state.view)));
  }
}

/// Whether the main view has replaced the frames that the next pieces of the picture read, or the memory that
/// their descriptors name.
bool PrivateRenderer::inputs_lost(const ViewState& state) {
  if (state.slot == nullptr || !state.view) return false;
  const VolumeInFlight& slot = *state.slot;
  if (state.bindings_version != slot.bindings_version()) return true;
  // The first piece of passes 2 and 3, which was submitted as they began, has read the frames.
  if (state.phase == WorkPhase::kLighting) return false;
  return state.frames_version != slot.frames_version() || !slot.frames_ready();
}

std::array<PrivateStatus, kMostPrivateViews> PrivateRenderer::status(const Shown& shown) const {
  std::array<PrivateStatus, kMostPrivateViews> all;
  for (std::size_t index = 0; index < all.size(); ++index) {
    const ViewState& state = states_[index];
    all[index] = {.phase = state.phase,
                  .wanted_view_id = state.view ? state.wanted.view_id : 0,
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
                  .cast_submitted = state.view && state.view->cast_submitted(),
                  .light_submitted = state.view && state.view->light_steps().submitted(),
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
  ViewRenderer& view = *state.view;
  const auto history = state.wanted.own_camera ? ViewRenderer::History::kNone : shown.history;
  switch (step) {
    case PrivateStep::kDrop:
      return {};
    case PrivateStep::kRelight:
      take_request(state, shown);
      if (history == ViewRenderer::History::kUsable) shown.previous.share_steady();
      return light(state, history);
    case PrivateStep::kLightShared:
      take_request(state, shown);
      view.copy_cast(shown.slot.view(), shown.slot.bindings());
      if (history == ViewRenderer::History::kUsable) shown.previous.share_steady();
      view.follow(shown.previous.view());
      return light(state, history);
    case PrivateStep::kBeginCast:
      take_request(state, shown);
      return begin_cast(state, shown);
    case PrivateStep::kCastBand:
      return view.cast_next_band(state.slot->bindings());
    case PrivateStep::kLightCast:
      return light(state, ViewRenderer::History::kNone);
    case PrivateStep::kLightPiece:
      return view.light_next_piece();
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
  if (state.wanted.own_camera) {
    state.scene = state.wanted.scene.scene;
    state.cast_number = 0;
  } else {
    state.scene = relit(shown.cast_scene, state.wanted.scene.scene);
    state.cast_number = shown.cast_number;
  }
}

Result<void> PrivateRenderer::begin_cast(ViewState& state, const Shown& shown) {
  ViewRenderer& view = *state.view;
  view.bind(shown.slot.bindings());
  if (auto begun = view.begin_cast(state.scene, shown.slot.bindings()); !begun) return begun;
  state.phase = WorkPhase::kCasting;
  counters_.private_casts.add();
  return view.cast_next_band(shown.slot.bindings());
}

Result<void> PrivateRenderer::light(ViewState& state, ViewRenderer::History history) {
  state.phase = WorkPhase::kLighting;
  state.stamp.view = picture_view(state.scene, view_config_.size);
  ViewRenderer& view = *state.view;
  if (auto begun = view.begin_light(state.scene, state.slot->bindings(), history); !begun) return begun;
  return view.light_next_piece();
}

bool PrivateRenderer::collect() {
  bool any = false;
  for (ViewState& state : states_) {
    if (!state.awaits_collection() || state.outstanding()) continue;
    const auto stage_ms = state.view->stage_ms();
    if (device_.gpu->fault() != nullptr)
      return false;  // what a lost GPU has left in the memory may be an old picture
    state.phase = WorkPhase::kIdle;
    state.drawn = state.wanted.view_id == state.stamp.view_id;
    if (!state.drawn) continue;
    state.stamp.picture_id = ++state.pictures;
    state.stamp.stage_ms = stage_ms;
    state.stamp.finished_time_ns = now_ns();
    Picture& picture = state.wanted.pictures->draft();
    picture.stamp = state.stamp;
    picture.width = view_config_.size.width;
    picture.height = view_config_.size.height;
    const auto rgba = state.view->picture();
    picture.rgba.assign(rgba.begin(), rgba.end());
    const auto depth_mm = state.view->depth_mm();
    picture.depth_mm.assign(depth_mm.begin(), depth_mm.end());
    state.wanted.pictures->publish();
    counters_.private_pictures.add();
    any = true;
  }
  return any;
}

const ViewRenderer* PrivateRenderer::outstanding_view() const {
  const auto state = std::ranges::find_if(states_, [](const ViewState& each) { return each.outstanding(); });
  return state == states_.end() ? nullptr : &*state->view;
}

bool PrivateRenderer::busy() const {
  return std::ranges::any_of(
      states_, [](const ViewState& state) { return state.awaits_collection() || state.outstanding(); });
}

bool PrivateRenderer::reads(const VolumeInFlight& slot) const {
  return std::ranges::any_of(
      states_, [&](const ViewState& state) { return state.slot == &slot && state.outstanding(); });
}

}  // namespace fanlight
