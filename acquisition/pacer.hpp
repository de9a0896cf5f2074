#pragma once

#include <cstdint>
#include <stop_token>

#include "proto/doorbell.hpp"

namespace fanlight {

/// Where the capture times of a source without a pace of its own begin. Not 0, which reads like "never set".
inline constexpr std::int64_t kSimulatedStartNs = 1'000'000'000;

/// Holds a source back until a frame is due. One thread.
class Pacer {
 public:
  /// Waits until fanlight::now_ns() reaches due_ns and returns true, or false as soon as `stop` is
  /// requested. Allocates nothing.
  bool wait_until(std::int64_t due_ns, const std::stop_token& stop);

 private:
  Doorbell bell_;
};

}  // namespace fanlight
