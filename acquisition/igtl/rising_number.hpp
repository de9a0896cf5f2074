// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

namespace fanlight {

/// A sender's numbers from 0, since what it sent before was sent to others; continued where the sender begins
/// to restart. A number that is a little smaller came out of order, and stays so. One thread.
class RisingNumber {
 public:
  /// Larger numbers are cut to this one: they must not make the sum wrap.
  static constexpr std::uint64_t kMost = std::uint64_t{1} << 48;

  /// `most_reordered`: by so much a number may be smaller than the one before it and count as out of order.
  explicit RisingNumber(std::uint64_t most_reordered) : most_reordered_(most_reordered) {}

  /// `is_first`: the first one of a connection, which may count from 0 again.
  std::uint64_t continued(std::uint64_t sent, bool is_first) {
    sent = std::min(sent, kMost);
    if (!last_sent_) base_ = sent;
    const bool restarts = last_sent_ && (is_first || sent + most_reordered_ < *last_sent_);
    if (restarts && sent < *last_sent_) {
      first_ = most_ + 1;
      base_ = sent;
    }
    last_sent_ = sent;
    // Before the first one that came there is none.
    const std::uint64_t number = first_ + (sent - std::min(sent, base_));
    most_ = std::max(most_, number);
    return number;
  }

 private:
  std::uint64_t most_reordered_;
  std::optional<std::uint64_t> last_sent_;  // absent: none was sent yet
  std::uint64_t most_ = 0;
  std::uint64_t first_ = 0;  // what base_ became
  std::uint64_t base_ = 0;   // the sender's first number of this count
};

}  // namespace fanlight
