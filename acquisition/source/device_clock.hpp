// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <utility>

namespace fanlight {

/// Converts times of a probe's own clock to this host's steady clock. A frame cannot arrive before it was
/// taken, so the smallest observed delay is the best estimate: the offset of the clocks is the minimum of
/// arrival time minus device time over the last one to two windows. The windows follow clocks that drift
/// apart. The transfer time of the fastest frame (below a millisecond on USB) remains as an error. One
/// thread.
class DeviceClock {
 public:
  static constexpr std::int64_t kWindowNs = 10'000'000'000;

  /// Host time of a frame taken at device_time_ns that arrived at arrival_ns; never later than its arrival.
  std::int64_t host_time_ns(std::uint64_t device_time_ns, std::int64_t arrival_ns) {
    const auto device_ns = static_cast<std::int64_t>(device_time_ns);
    if (arrival_ns - window_start_ns_ >= kWindowNs) {
      last_ns_ = window_start_ns_ == 0 ? kNone : current_ns_;
      current_ns_ = kNone;
      window_start_ns_ = arrival_ns;
    }
    // Unsigned arithmetic: an absurd device time wraps instead of overflowing.
    const auto difference_ns =
        static_cast<std::int64_t>(static_cast<std::uint64_t>(arrival_ns) - device_time_ns);
    // A device time far ahead of all others is an error of the probe, unless the next one agrees: then the
    // probe's clock was set.
    const std::int64_t known_ns = std::min(current_ns_, last_ns_);
    // As a double: numbers far apart would overflow.
    const double change_ns =
        known_ns == kNone ? 0 : static_cast<double>(difference_ns) - static_cast<double>(known_ns);
    const bool jumps = change_ns < -kJumpNs;
    if (jumps && !std::exchange(jumped_, true)) return arrival_ns;
    jumped_ = jumps;
    // A time far behind the others is no frame that took so long either: the probe's clock was set back.
    if (change_ns > kSetBackNs) {
      if (!std::exchange(fell_back_, true)) return arrival_ns;
      last_ns_ = current_ns_ = kNone;
    }
    fell_back_ = false;
    current_ns_ = std::min(current_ns_, difference_ns);
    const std::int64_t nearest_ns = std::min(current_ns_, last_ns_);
    return static_cast<std::int64_t>(static_cast<std::uint64_t>(device_ns) +
                                     static_cast<std::uint64_t>(nearest_ns));
  }

  void reset() { *this = {}; }

 private:
  static constexpr double kJumpNs = 1e9;
  static constexpr double kSetBackNs = 15e9;
  static constexpr std::int64_t kNone = std::numeric_limits<std::int64_t>::max();
  std::int64_t window_start_ns_ = 0;
  std::int64_t current_ns_ = kNone;
  std::int64_t last_ns_ = kNone;
  bool jumped_ = false;
  bool fell_back_ = false;
};

}  // namespace fanlight
