// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>

namespace fanlight {

/// Nanoseconds on the steady clock: the only time base for captures, pictures and their age.
inline std::int64_t now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

/// Seconds since 1970 in UTC, for names and records that people read; it may jump.
inline std::int64_t utc_now_s() {
  return std::chrono::duration_cast<std::chrono::seconds>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

/// Nanoseconds since 1970 in UTC, for other programs; it may jump.
inline std::uint64_t utc_now_ns() {
  return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::nanoseconds>(
                                        std::chrono::system_clock::now().time_since_epoch())
                                        .count());
}

/// A source of such times that tests replace.
using Clock = std::function<std::int64_t()>;

}  // namespace fanlight
