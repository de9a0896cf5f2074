// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace fanlight {

/// Decides when a GPU that is lost again and again is given up: at the third loss within a minute, or in a
/// row without a picture between them (a GPU that hangs at once may take longer than a minute for three).
/// Pure logic: time is a parameter.
class LossRecord {
 public:
  static constexpr std::size_t kMost = 3;
  static constexpr std::int64_t kWindowNs = 60'000'000'000;

  /// Notes a loss. True where the GPU is to be given up.
  bool lost(std::int64_t now_ns) {
    times_ns_[losses_++ % kMost] = now_ns;
    ++in_a_row_;
    const std::int64_t oldest_ns = times_ns_[losses_ % kMost];  // of the last kMost losses
    return in_a_row_ >= kMost || (losses_ >= kMost && now_ns - oldest_ns < kWindowNs);
  }

  void picture_finished() { in_a_row_ = 0; }

 private:
  std::array<std::int64_t, kMost> times_ns_{};  // of the last losses, by number modulo kMost
  std::size_t losses_ = 0;
  std::size_t in_a_row_ = 0;  // since the last picture
};

}  // namespace fanlight
