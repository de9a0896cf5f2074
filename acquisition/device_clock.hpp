#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <utility>

namespace fanlight {

/// Puts the times of a probe's own clock on this host's steady clock. A frame cannot arrive before it was
/// taken, so the smallest delay seen is the nearest to the truth: the difference of the clocks is the minimum
/// of arrival less device time over the last one to two windows, which follows clocks that drift apart. The
/// way of the fastest frame (below a millisecond on USB) stays in it. One thread.
class DeviceClock {
 public:
  static constexpr std::int64_t kWindowNs = 10'000'000'000;

  /// Host time of a frame taken at device_time_ns and first seen at arrival_ns; never after its arrival.
  std::int64_t host_time_ns(std::uint64_t device_time_ns, std::int64_t arrival_ns) {
    const auto device_ns = static_cast<std::int64_t>(device_time_ns);
    if (arrival_ns - window_start_ns_ >= kWindowNs) {
      last_ns_ = window_start_ns_ == 0 ? kNone : current_ns_;
      current_ns_ = kNone;
      window_start_ns_ = arrival_ns;
    }
    // Through unsigned numbers, where a nonsensical device time wraps instead of overflowing.
    const auto difference_ns =
        static_cast<std::int64_t>(static_cast<std::uint64_t>(arrival_ns) - device_time_ns);
    // A time far ahead of all others is a probe that erred, unless the next says the same: then its clock was
    // set.
    const std::int64_t known_ns = std::min(current_ns_, last_ns_);
    const bool leaps = known_ns != kNone && difference_ns < known_ns - kLeapNs;
    if (leaps && !std::exchange(leapt_, true)) return arrival_ns;
    leapt_ = leaps;
    current_ns_ = std::min(current_ns_, difference_ns);
    const std::int64_t nearest_ns = std::min(current_ns_, last_ns_);
    return static_cast<std::int64_t>(static_cast<std::uint64_t>(device_ns) +
                                     static_cast<std::uint64_t>(nearest_ns));
  }

  void reset() { *this = {}; }

 private:
  static constexpr std::int64_t kLeapNs = 1'000'000'000;
  static constexpr std::int64_t kNone = std::numeric_limits<std::int64_t>::max();
  std::int64_t window_start_ns_ = 0;
  std::int64_t current_ns_ = kNone;
  std::int64_t last_ns_ = kNone;
  bool leapt_ = false;
};

}  // namespace fanlight
