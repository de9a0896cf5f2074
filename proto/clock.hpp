#pragma once

#include <chrono>
#include <cstdint>

namespace fanlight {

/// Nanoseconds on the steady clock: the one time base for captures, pictures and their age.
inline std::int64_t now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

}  // namespace fanlight
