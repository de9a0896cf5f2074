// SPDX-License-Identifier: Apache-2.0
#include "server/http/liveness_watch.hpp"

#include <spdlog/spdlog.h>

#include <chrono>

#include "proto/base/clock.hpp"

namespace fanlight {

namespace {

constexpr auto kInterval = std::chrono::milliseconds(250);

PictureLiveness::Source liveness_source(const std::string& source_state, bool probe_lost) {
  using State = PictureLiveness::Source::State;
  if (source_state == "running") return {.state = State::kRunning, .failure = "", .probe_lost = probe_lost};
  if (source_state == "ended") return {.state = State::kEnded, .failure = "", .probe_lost = probe_lost};
  return {.state = State::kFailed, .failure = source_state, .probe_lost = probe_lost};
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
  if (dependencies_.health != nullptr) {
    if (const RenderHealth* const health = dependencies_.health->newest()) liveness.health_changed(*health);
  }
  if (!liveness.update(liveness_source(dependencies_.source_state(), dependencies_.probe.lost()), now_ns()))
    return;
  log();
  dependencies_.sessions.liveness_changed();
}

void LivenessWatch::log() const {
  const PictureLiveness::Report& report = dependencies_.liveness.report();
  if (report.live() || report.state == PictureLiveness::State::kWaiting)
    return spdlog::info("{}", report.sentence);
  spdlog::warn("the picture is {}, {:.1f} s old: {}", PictureLiveness::name(report.state), report.age_s,
               report.sentence);
}

}  // namespace fanlight
