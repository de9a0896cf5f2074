// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

namespace fanlight {

/// A sender's numbers from 0, since what it sent before was sent to others; continued where the sender begins
/// to count anew. They only grow. One thread.
class RisingNumber {
 public:
  /// Larger numbers are cut to this one: they must not make the sum wrap.
  static constexpr std::uint64_t kMost = std::uint64_t{1} << 48;

  std::uint64_t continued(std::uint64_t sent) {
    sent = std::min(sent, kMost);
    if (!last_sent_) base_ = sent;
    if (last_sent_ && sent < *last_sent_) {
      first_ = last_ + 1;
      base_ = sent;
    }
    last_sent_ = sent;
    last_ = first_ + (sent - base_);
    return last_;
  }

 private:
  std::optional<std::uint64_t> last_sent_;  // absent: none was sent yet
  std::uint64_t last_ = 0;
  std::uint64_t first_ = 0;  // what base_ became
  std::uint64_t base_ = 0;   // the sender's first number of this count
};

}  // namespace fanlight
