// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>

namespace fanlight {

/// Converts times of a sender's own clock to this host's steady clock. A frame cannot arrive before it was
/// taken, so the smallest delay seen is the best estimate of the clocks' offset: arrival time minus device
/// time. The estimate rises again only as fast as clocks drift apart, so that frames that are delayed from
/// now on keep their times, and look late. The transfer time of the fastest frame (below a millisecond on
/// USB) remains as an error, as does a delay that there was from the first frame on. A clock that was set
/// back by less than the time between two frames cannot be told from a delay, and looks like one. One thread.
class DeviceClock {
 public:
  /// Clocks that drift apart by more are followed late. Quartz oscillators have 100 parts per million at
  /// most. A delay of a second is taken for drift after half an hour.
  static constexpr std::int64_t kMostDriftPpm = 500;

  /// Host time of a frame taken at device_time_ns that arrived at arrival_ns; never later than its arrival.
  std::int64_t host_time_ns(std::uint64_t device_time_ns, std::int64_t arrival_ns) {
    // Unsigned arithmetic: an absurd device time wraps instead of overflowing.
    const auto difference_ns =
        static_cast<std::int64_t>(static_cast<std::uint64_t>(arrival_ns) - device_time_ns);
    if (!known_) {
      begin(device_time_ns, difference_ns, arrival_ns);
    } else if (was_set(device_time_ns, difference_ns)) {
      // An error of the sender, unless the next one agrees: then its clock was set.
      if (!std::exchange(odd_, true)) return arrival_ns;
      begin(device_time_ns, difference_ns, arrival_ns);
    }
    odd_ = false;
    const std::int64_t passed_ns = std::max<std::int64_t>(arrival_ns - seen_ns_, 0);
    const auto drifted_ns =
        static_cast<std::int64_t>(static_cast<std::uint64_t>(offset_ns_) +
                                  static_cast<std::uint64_t>(passed_ns / 1'000'000 * kMostDriftPpm));
    offset_ns_ = std::min(difference_ns, drifted_ns);
    // Shorter passed times than those that were counted are kept for the next frame.
    if (passed_ns >= 1'000'000) seen_ns_ = arrival_ns;
    device_ns_ = device_time_ns;
    return static_cast<std::int64_t>(device_time_ns + static_cast<std::uint64_t>(offset_ns_));
  }

  void reset() { *this = {}; }

 private:
  /// Frames may come out of order, but not by this much.
  static constexpr double kJumpNs = 1e9;

  void begin(std::uint64_t device_time_ns, std::int64_t difference_ns, std::int64_t arrival_ns) {
    known_ = true;
    device_ns_ = device_time_ns;
    offset_ns_ = difference_ns;
    seen_ns_ = arrival_ns;
  }
  /// A time far ahead of the others, or before the frame before it. As doubles: numbers far apart would
  /// overflow.
  bool was_set(std::uint64_t device_time_ns, std::int64_t difference_ns) const {
    const bool ahead = static_cast<double>(difference_ns) - static_cast<double>(offset_ns_) < -kJumpNs;
    const bool back = static_cast<double>(device_time_ns) - static_cast<double>(device_ns_) < -kJumpNs;
    return ahead || back;
  }

  bool known_ = false;
  bool odd_ = false;             // the last frame's time was far from the others
  std::uint64_t device_ns_ = 0;  // of the last frame
  std::int64_t offset_ns_ = 0;   // host minus device
  std::int64_t seen_ns_ = 0;     // arrival of the frame up to which the drift is counted
};

}  // namespace fanlight
