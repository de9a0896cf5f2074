// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <stop_token>

#include "proto/exchange/doorbell.hpp"

namespace fanlight {

/// First capture time of a source without pacing. Not 0, which reads like "never set".
inline constexpr std::int64_t kSimulatedStartNs = 1'000'000'000;

/// Delays a source until a frame is due. One thread.
class Pacer {
 public:
  /// Blocks until fanlight::now_ns() reaches due_ns and returns true; returns false when `stop` is requested.
  /// Allocates nothing.
  bool wait_until(std::int64_t due_ns, const std::stop_token& stop);

 private:
  Doorbell bell_;
};

}  // namespace fanlight
