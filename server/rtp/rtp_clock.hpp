// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace fanlight {

inline constexpr std::uint32_t kRtpClockHz = 90'000;

/// The time stamps of an RTP stream: ticks of kRtpClockHz from a random first one, in 32 bits that wrap. One
/// thread.
class RtpClock {
 public:
  RtpClock() = default;
  /// `first`: the random part (RFC 3550, section 5.1). `now_ns`: no picture is stamped as older.
  RtpClock(std::uint32_t first, std::int64_t now_ns) : first_(first), last_ticks_(ticks_at(now_ns)) {}

  /// The stamp of a picture of this time, and later than that of the one before: a picture on show may be
  /// hours old, or be encoded once more.
  std::uint32_t next(std::int64_t time_ns);

  /// Of any time, for reports.
  std::uint32_t at(std::int64_t time_ns) const {
    return first_ + static_cast<std::uint32_t>(ticks_at(time_ns));
  }

 private:
  static std::int64_t ticks_at(std::int64_t time_ns);

  std::uint32_t first_ = 0;
  std::int64_t last_ticks_ = 0;  // 64 bits: half the range of 32 is less than seven hours
};

}  // namespace fanlight
