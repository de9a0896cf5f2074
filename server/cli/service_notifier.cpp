// SPDX-License-Identifier: Apache-2.0
#include "server/cli/service_notifier.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <systemd/sd-daemon.h>

#include <algorithm>
#include <ctime>
#include <utility>

#include "proto/base/clock.hpp"

namespace fanlight {

ServiceNotifier::ServiceNotifier(std::vector<LoopWatch::Loop> loops) {
  std::uint64_t watchdog_us = 0;
  if (sd_watchdog_enabled(0, &watchdog_us) <= 0) return;
  // Half of it, as sd_watchdog_enabled(3) advises: a loop that moves seldom is not taken for a still one, and
  // a still one is reported before systemd acts.
  // A loop that waits beats once a second only.
  constexpr std::int64_t kLeastNs = 3'000'000'000;
  watch_.emplace(std::move(loops), std::max(static_cast<std::int64_t>(watchdog_us) * 1000 / 2, kLeastNs),
                 now_ns());
}

void ServiceNotifier::ready(const std::string& url) {
  sd_notify(0, fmt::format("READY=1\nSTATUS=Serves on {}", url).c_str());
}

void ServiceNotifier::reloading() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  // With the time, so that Type=notify-reload knows which reload it was.
  sd_notify(0, fmt::format("RELOADING=1\nMONOTONIC_USEC={}",
                           std::int64_t{now.tv_sec} * 1'000'000 + now.tv_nsec / 1000)
                   .c_str());
}

void ServiceNotifier::reloaded() {
  sd_notify(0, "READY=1");
}

void ServiceNotifier::stopping() {
  sd_notify(0, "STOPPING=1");
}

void ServiceNotifier::second_passed(const PictureLiveness::Report& report) {
  if (std::string state = fmt::format("STATUS={}", report.sentence); state != reported_) {
    reported_ = std::move(state);
    sd_notify(0, reported_.c_str());
  }
  if (!watch_) return;
  const LoopWatch::Loop* const still = watch_->still(now_ns());
  if (still == nullptr) {
    sd_notify(0, "WATCHDOG=1");
  } else if (!still_) {
    spdlog::error(
        "the loop of {} does not respond, so the watchdog is not notified: systemd will restart the service",
        still->name);
  }
  still_ = still != nullptr;
}

}  // namespace fanlight
