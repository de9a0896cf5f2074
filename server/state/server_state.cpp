// SPDX-License-Identifier: Apache-2.0
#include "server/state/server_state.hpp"

#include <utility>

#include "proto/base/clock.hpp"
#include "server/state/path_privacy.hpp"

namespace fanlight {

ServerState::ServerState(const Config& config, const PipelinePorts& ports, ServerCounters& server_counters,
                         std::function<void()> presets_changed)
    : counters(server_counters),
      pipeline(ports.counters),
      description(config.description),
      scene_store(config.initial_scene, config.suggested_scene, ports.scenes, config.chosen_fields),
      probe(ports.probe, config.probe_control),
      liveness(pipeline, now_ns()),
      views({.views = ports.private_views,
             .ends = ports.private_view_ends,
             .bell = ports.bell,
             .scene_store = scene_store,
             .render = pipeline.render,
             .counters = counters},
            config.most_private_views, description.picture_width, description.picture_height),
      surveys(ports.survey_orders, ports.survey_results),
      recording(config.recording, ports.recording, utc_now_s),
      replay(ports.replay, description.path),
      cine(ports.cine),
      demand(ports.audience),
      presets(std::move(presets_changed)),
      default_view(config.finds_view, scene_store, surveys, description.notes),
      source_state_(ports.source_state) {}

void ServerState::picture_shown(const Picture& picture, std::int64_t now) {
  views.main_shown(picture.stamp, now);
  liveness.shown(picture.stamp, now);
  times.shown(picture.stamp);
  recording.picture_shown(picture.stamp, picture.width, picture.height, scene_store);
  demand.picture_shown(now);
  default_view.picture_shown(picture.stamp, now);
}

std::string ServerState::source_state() const {
  if (replay.status().state == ReplayStatus::State::kEnded) return "ended";
  return without_path(source_state_(), description.path, "the recording");
}

}  // namespace fanlight
