// SPDX-License-Identifier: Apache-2.0
#include "server/state/server_state.hpp"

#include "proto/base/clock.hpp"
#include "server/state/path_privacy.hpp"

namespace fanlight {

ServerState::ServerState(const Config& config, const Dependencies& dependencies)
    : counters(dependencies.counters),
      pipeline(dependencies.ports.counters),
      description(config.description),
      scene_store(config.initial_scene, config.suggested_scene, dependencies.ports.render.scenes,
                  config.chosen_fields),
      probe(dependencies.ports.probe, config.probe_control),
      liveness(pipeline, now_ns()),
      views({.link = dependencies.ports.render,
             .scene_store = scene_store,
             .render = pipeline.render,
             .counters = counters},
            config.most_private_views, description.picture_size),
      volumes(dependencies.ports.render, dependencies.executor),
      surveys({.find = dependencies.find_surface,
               .volumes = volumes,
               .executor = dependencies.executor,
               .scene_in_force = [this] { return scene_store.in_force().scene; },
               .answered = dependencies.survey_answered}),
      fluid({.measure = dependencies.measure_fluid,
             .volumes = volumes,
             .executor = dependencies.executor,
             .answered = dependencies.fluid_answered}),
      recording(config.recording, dependencies.ports.recording, utc_now_s),
      replay(dependencies.ports.replay, description.path),
      cine(dependencies.ports.render),
      demand(config.renders_unwatched ? nullptr : &dependencies.ports.render.audience),
      presets(dependencies.presets_changed),
      measurements(dependencies.measurements_changed),
      default_view(config.finds_view, scene_store, surveys, description.notes),
      source_state_(dependencies.ports.source_state) {}

void ServerState::picture_shown(const Picture& picture, std::int64_t now) {
  PictureStamp usual = picture.stamp;
  // Views of a camera of their own have the usual size.
  const PictureSize size{.width = picture.width, .height = picture.height};
  const double share =
      static_cast<double>(description.picture_size.pixels()) / static_cast<double>(size.pixels());
  for (double& ms : usual.stage_ms) ms *= share;
  views.main_shown(usual, now);
  scene_store.note_shown(picture.stamp.scene_revision);
  liveness.shown(picture.stamp, now);
  times.shown(picture.stamp);
  recording.picture_shown(picture, description.picture_size, scene_store);
  demand.picture_shown(now);
  default_view.picture_shown(picture.stamp, now);
}

FrameOrigin ServerState::frame_origin() const {
  return probe.status().origin.value_or(description.origin);
}

std::string ServerState::source_state() const {
  if (replay.status().state == ReplayStatus::State::kEnded) return "ended";
  return without_path(source_state_(), description.path, "the recording");
}

}  // namespace fanlight
