// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <csignal>
#include <ctime>

namespace fanlight {

/// SIGINT, SIGTERM and SIGHUP, taken by the thread that asks. Made before other threads, which
/// inherit it.
class EndSignals {
 public:
  EndSignals() {
    sigemptyset(&set_);
    sigaddset(&set_, SIGINT);
    sigaddset(&set_, SIGTERM);
    sigaddset(&set_, SIGHUP);  // of a terminal that is closed
    pthread_sigmask(SIG_BLOCK, &set_, nullptr);
  }
  /// Waits for a signal, at most so long; whether one came.
  bool wait_ms(long milliseconds) {
    const timespec limit{.tv_sec = milliseconds / 1000, .tv_nsec = milliseconds % 1000 * 1'000'000};
    return sigtimedwait(&set_, nullptr, &limit) > 0;
  }

 private:
  sigset_t set_{};
};

}  // namespace fanlight
