// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>

namespace fanlight {

/// How much a client may send within a second. Beyond it, messages stay in the socket until the next second,
/// and changes of the stream are refused. Pure logic: the owner calls refill() once a second.
class InputBudget {
 public:
  /// A dragged light sends a change with every picture of a fast screen.
  static constexpr int kMessagesPerSecond = 500;
  static constexpr std::size_t kBytesPerSecond = 256 << 10;
  /// Each may have a picture encoded again.
  static constexpr int kStreamChangesPerSecond = 3;
  /// A display needs none. Each is answered by the library.
  static constexpr int kPingsPerSecond = 20;

  /// A second has passed.
  void refill() { *this = {}; }

  /// Whether the next message may be read. A message may exceed the bytes that are left.
  bool may_read() const { return messages_left_ > 0 && bytes_left_ > 0; }

  /// A read begins. Precondition: may_read().
  void begin_read() { --messages_left_; }

  /// A message of this length was read.
  void add_bytes(std::size_t bytes) { bytes_left_ -= std::min(bytes_left_, bytes); }

  /// Uses one of the stream changes; false if none is left.
  bool take_stream_change() {
    if (stream_changes_left_ == 0) return false;
    --stream_changes_left_;
    return true;
  }

  /// A ping came; false if there were too many.
  bool take_ping() { return pings_left_ > 0 && pings_left_-- > 0; }

 private:
  int messages_left_ = kMessagesPerSecond;
  std::size_t bytes_left_ = kBytesPerSecond;
  int stream_changes_left_ = kStreamChangesPerSecond;
  int pings_left_ = kPingsPerSecond;
};

}  // namespace fanlight
