// SPDX-License-Identifier: Apache-2.0
#include "server/service/liveness_watch.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <chrono>

#include "proto/base/clock.hpp"

namespace fanlight {

namespace {

constexpr auto kInterval = std::chrono::milliseconds(250);

PictureLiveness::Source liveness_source(const std::string& source_state, bool probe_lost,
                                        const ReplayStatus& replay, bool frozen, bool resting) {
  using State = PictureLiveness::Source::State;
  PictureLiveness::Source source{.state = State::kRunning, .failure = "", .probe_lost = probe_lost};
  source.is_replay = replay.state != ReplayStatus::State::kAbsent;
  source.paused = replay.state == ReplayStatus::State::kPaused;
  source.frozen = frozen;
  source.resting = resting;
  if (source_state == "ended") {
    source.state = State::kEnded;
  } else if (source_state != "running") {
    source.state = State::kFailed;
    source.failure = source_state;
  } else if (replay.state == ReplayStatus::State::kFailed) {
    source.state = State::kFailed;
    source.failure = replay.trouble;
  }
  return source;
}

}  // namespace

LivenessWatch::LivenessWatch(boost::asio::io_context& loop, const Dependencies& dependencies)
    : dependencies_(dependencies), timer_(loop, kInterval, [this] { update(); }) {}

void LivenessWatch::update() {
  ServerState& state = dependencies_.state;
  const std::size_t clients = dependencies_.sessions.open_count() + dependencies_.other_clients();
  const bool demand_changed = state.demand.update(clients, state.recording.is_active(), now_ns());
  if (demand_changed && state.demand.resting()) dependencies_.hub.forget_main_view();
  auto source = liveness_source(state.source_state(), state.probe.lost(), state.replay.status(),
                                state.cine.is_frozen(), state.demand.resting());
  source.trouble = state.probe.trouble();
  source.origin = state.frame_origin();
  dependencies_.scene.update(now_ns());
  source.scene_trouble = dependencies_.scene.trouble();
  if (!state.liveness.update(source, now_ns())) return;
  log();
  dependencies_.sessions.notify(Notice::kLiveness);
  dependencies_.changed();
}

void LivenessWatch::log() const {
  const PictureLiveness::Report& report = dependencies_.state.liveness.report();
  if (report.live() || report.state == PictureLiveness::State::kWaiting ||
      report.state == PictureLiveness::State::kReplay || report.state == PictureLiveness::State::kResting ||
      report.state == PictureLiveness::State::kFrozen)
    return spdlog::info("{}", report.sentence);
  const std::string age = report.age_s < 0 ? "" : fmt::format(", {:.1f} s old", report.age_s);
  spdlog::warn("the picture is {}{}: {}", PictureLiveness::name(report.state), age, report.sentence);
}

}  // namespace fanlight
