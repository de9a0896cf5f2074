// SPDX-License-Identifier: Apache-2.0
#include "renderer/schedule/watchdog.hpp"

#include <algorithm>

namespace fanlight {

Watchdog::Pace Watchdog::observe(std::span<const Lane> lanes, std::int64_t now_ns) {
  const std::int64_t gap_ns = std::clamp<std::int64_t>(now_ns - last_ns_, 0, kMostGapNs);
  last_ns_ = now_ns;
  std::int64_t longest_wait_ns = 0;
  for (std::size_t index = 0; index < std::min(lanes.size(), watched_.size()); ++index) {
    const Lane& lane = lanes[index];
    Watched& watched = watched_[index];
    const bool same = watched.submission == lane.submissions;
    if (watched.outstanding) {
      watched.waited_ns += gap_ns;
      if (!same || !lane.outstanding) finished(watched.waited_ns);
    }
    // A submission that was made since the last call has waited for less than the gap: it counts from now on.
    if (!same || !lane.outstanding) watched.waited_ns = 0;
    watched.submission = lane.submissions;
    watched.outstanding = lane.outstanding;
    longest_wait_ns = std::max(longest_wait_ns, watched.waited_ns);
  }
  if (longest_wait_ns >= hung_after_ns()) return Pace::kHung;
  return longest_wait_ns >= slow_after_ns() ? Pace::kSlow : Pace::kUsual;
}

std::int64_t Watchdog::longest_ns() const {
  return *std::ranges::max_element(took_ns_);
}

std::int64_t Watchdog::hung_after_ns() const {
  return std::min(std::max(limits_.least_hung_ns, kHungTimes * longest_ns()), limits_.most_hung_ns);
}

std::int64_t Watchdog::slow_after_ns() const {
  // Always well before the limit above.
  return std::min(std::max(limits_.least_slow_ns, kSlowTimes * longest_ns()), hung_after_ns() / 4);
}

void Watchdog::finished(std::int64_t took_ns) {
  took_ns_[next_] = took_ns;
  next_ = (next_ + 1) % took_ns_.size();
}

}  // namespace fanlight
