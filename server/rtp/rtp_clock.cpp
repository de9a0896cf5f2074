// SPDX-License-Identifier: Apache-2.0
#include "server/rtp/rtp_clock.hpp"

#include <algorithm>

namespace fanlight {

std::int64_t RtpClock::ticks_at(std::int64_t time_ns) {
  constexpr std::int64_t kSecondNs = 1'000'000'000;
  return time_ns / kSecondNs * kRtpClockHz + time_ns % kSecondNs * kRtpClockHz / kSecondNs;
}

std::uint32_t RtpClock::next(std::int64_t time_ns) {
  last_ticks_ = std::max(ticks_at(time_ns), last_ticks_ + 1);
  return first_ + static_cast<std::uint32_t>(last_ticks_);
}

}  // namespace fanlight
