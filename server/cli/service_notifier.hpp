// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "server/state/loop_watch.hpp"
#include "server/state/picture_liveness.hpp"

namespace fanlight {

/// Notifies systemd about the service, as sd_notify(3) describes: that it is ready, reloads or stops, its
/// state in a sentence, and, where WatchdogSec is set, once a second that its loops move. Without systemd
/// nothing is reported. Server thread only.
class ServiceNotifier {
 public:
  explicit ServiceNotifier(std::vector<LoopWatch::Loop> loops);

  static void ready(const std::string& url);
  static void reloading();
  static void reloaded();
  static void stopping();
  /// Once a second. Where a loop stands still, the watchdog gets no sign any more, and the log says why.
  void second_passed(const PictureLiveness::Report& report);

 private:
  std::optional<LoopWatch> watch_;  // absent: no watchdog was requested
  std::string reported_;            // the state that was reported last
  bool still_ = false;
};

}  // namespace fanlight
