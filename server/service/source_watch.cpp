// SPDX-License-Identifier: Apache-2.0
#include "server/service/source_watch.hpp"

#include <spdlog/spdlog.h>

#include <utility>

#include "proto/base/clock.hpp"

namespace fanlight {

void SourceWatch::update() {
  if (state_.probe.update()) probe_changed();
  if (state_.replay.update()) replay_changed();
}

void SourceWatch::probe_changed() {
  const ProbeStatus& status = state_.probe.status();
  if (status.state != logged_.state || status.trouble != logged_.trouble ||
      status.settings != logged_.settings) {
    logged_ = status;
    spdlog::info("{}{}", state_.probe.sentence(), status.trouble.empty() ? "" : ": " + status.trouble);
  }
  const double half_rad = radians(status.settings.sweep_deg / 2);
  const bool has_geometry = status.geometry.columns > 0;
  Scene suggested = scene_for(status.geometry, -half_rad, half_rad);
  suggested.deadline = state_.scene_store.default_scene().deadline;  // by the device, not by the probe
  const bool scene_differs = has_geometry && state_.default_view.source_changed(suggested, now_ns());
  commands_.probe_changed();
  sessions_.notify(Notice::kProbe);
  if (scene_differs) sessions_.notify(Notice::kScene);
}

void SourceWatch::replay_changed() {
  const std::string before = std::exchange(replay_trouble_, state_.replay.message().trouble());
  if (!replay_trouble_.empty() && replay_trouble_ != before) spdlog::warn("{}", replay_trouble_);
  sessions_.notify(Notice::kReplay);
}

}  // namespace fanlight
