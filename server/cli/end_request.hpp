// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <functional>
#include <thread>
#include <utility>

#include "server/cli/end_signals.hpp"

namespace fanlight {

/// Whether a signal has asked the program to end, for one whose calls into a library may wait for minutes and
/// cannot be cancelled. Where the program does not end within kGraceMs, it is ended from here. Made before
/// other threads.
class EndRequest {
 public:
  static constexpr long kGraceMs = 10'000;

  /// `last_act`: what is to be done before the program is ended from here, on another thread; it may not
  /// wait.
  explicit EndRequest(std::function<void()> last_act)
      : last_act_(std::move(last_act)), thread_([this](const std::stop_token& over) { watch(over); }) {}

  const std::atomic<bool>& asked() const { return asked_; }

  /// Waits for the request, at most so long; whether it came.
  bool wait_ms(long milliseconds) const {
    for (long waited_ms = 0; waited_ms < milliseconds && !asked_; waited_ms += kLookMs) pause();
    return asked_;
  }

 private:
  static constexpr long kLookMs = 100;

  static void pause() { std::this_thread::sleep_for(std::chrono::milliseconds(kLookMs)); }

  void watch(const std::stop_token& over) {
    while (!signals_.wait_ms(kLookMs)) {
      if (over.stop_requested()) return;
    }
    asked_ = true;
    for (long waited_ms = 0; waited_ms < kGraceMs; waited_ms += kLookMs) {
      if (over.stop_requested()) return;
      pause();
    }
    last_act_();
    std::_Exit(EXIT_FAILURE);
  }

  EndSignals signals_;
  std::function<void()> last_act_;
  std::atomic<bool> asked_ = false;
  std::jthread thread_;  // the last member: it uses the others
};

}  // namespace fanlight
