// SPDX-License-Identifier: Apache-2.0
#include "server/http/liveness_watch.hpp"

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

void LivenessWatch::start() {
  if (chain_.broken()) wait();
}

void LivenessWatch::wait() {
  pause_.expires_after(kInterval);
  pause_.async_wait([this, link = chain_.link()](boost::system::error_code failure) {
    if (failure) return;
    update();
    wait();
  });
}

void LivenessWatch::update() {
  PictureLiveness& liveness = dependencies_.liveness;
  const std::size_t others = dependencies_.other_clients ? dependencies_.other_clients() : 0;
  const bool demand_changed = dependencies_.demand.update(dependencies_.sessions.open_count() + others,
                                                          dependencies_.recording.is_active(), now_ns());
  if (demand_changed && dependencies_.demand.resting()) dependencies_.hub.forget_main_view();
  if (dependencies_.health != nullptr) {
    if (const RenderHealth* const health = dependencies_.health->newest()) liveness.health_changed(*health);
  }
  auto source =
      liveness_source(dependencies_.source_state(), dependencies_.probe.lost(), dependencies_.replay.status(),
                      dependencies_.cine.is_frozen(), dependencies_.demand.resting());
  source.trouble = dependencies_.probe.trouble();
  if (!liveness.update(source, now_ns())) return;
  log();
  dependencies_.sessions.liveness_changed();
  if (dependencies_.changed) dependencies_.changed();
}

void LivenessWatch::log() const {
  const PictureLiveness::Report& report = dependencies_.liveness.report();
  if (report.live() || report.state == PictureLiveness::State::kWaiting ||
      report.state == PictureLiveness::State::kReplay || report.state == PictureLiveness::State::kResting ||
      report.state == PictureLiveness::State::kFrozen)
    return spdlog::info("{}", report.sentence);
  const std::string age = report.age_s < 0 ? "" : fmt::format(", {:.1f} s old", report.age_s);
  spdlog::warn("the picture is {}{}: {}", PictureLiveness::name(report.state), age, report.sentence);
}

}  // namespace fanlight
