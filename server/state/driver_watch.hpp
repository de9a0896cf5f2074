// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>

namespace fanlight {

/// How long the render thread has been inside one call of the GPU's driver, or in one turn of its work, from
/// RenderCounters::turn_began_ns. Time is a parameter. Pure logic.
///
/// Time counts only while the caller looks: a process that was stopped, or starved by others, learns nothing
/// about the driver in the meantime.
class DriverWatch {
 public:
  /// Longest time between two calls of observe() that counts.
  static constexpr std::int64_t kMostGapNs = 2'000'000'000;

  /// To be called at least once a second.
  void observe(std::int64_t turn_began_ns, std::int64_t now_ns) {
    const std::int64_t gap_ns =
        last_ns_ == 0 ? 0 : std::clamp<std::int64_t>(now_ns - last_ns_, 0, kMostGapNs);
    last_ns_ = now_ns;
    const bool same_turn = turn_began_ns != 0 && turn_began_ns == turn_ns_;
    turn_ns_ = turn_began_ns;
    silent_ns_ = same_turn ? silent_ns_ + gap_ns : 0;
  }

  /// 0 where the render thread rests, or has begun a turn since the last look.
  std::int64_t silent_ns() const { return silent_ns_; }

 private:
  std::int64_t turn_ns_ = 0;
  std::int64_t last_ns_ = 0;
  std::int64_t silent_ns_ = 0;
};

}  // namespace fanlight
