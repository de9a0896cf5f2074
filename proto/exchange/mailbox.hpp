// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "proto/exchange/doorbell.hpp"

namespace fanlight {

/// Passes the newest T from one writer thread to one reader thread; an unread older value is replaced. Three
/// slots, so neither side blocks, locks or allocates (the memory of T is reused: fill draft() in place).
template <typename T>
class Mailbox {
 public:
  /// Each publish rings `reader_bell`, which must outlive the mailbox. `initial` fills all three slots, so
  /// that the buffers of T are allocated here.
  explicit Mailbox(Doorbell& reader_bell, const T& initial = T{})
      : slots_{initial, initial, initial}, reader_bell_(reader_bell) {}

  /// The same; `prepare` is called with each slot, to reserve memory, which a copy would not keep.
  template <typename Prepare>
  Mailbox(Doorbell& reader_bell, const T& initial, Prepare prepare) : Mailbox(reader_bell, initial) {
    for (T& slot : slots_) prepare(slot);
  }

  /// Writer thread: the slot to fill next. It contains an older value, whose memory may be reused.
  T& draft() { return slots_[draft_]; }

  /// Writer thread: makes draft() the newest value. True where it replaced an unread one.
  bool publish() {
    const std::uint32_t previous = shared_.exchange(draft_ | kUnread, std::memory_order_acq_rel);
    draft_ = previous & kIndex;
    reader_bell_.ring();
    return (previous & kUnread) != 0;
  }

  /// Reader thread: the newest value; nullptr where there is none since the last call. Valid until the next
  /// call.
  const T* newest() {
    if ((shared_.load(std::memory_order_relaxed) & kUnread) == 0) return nullptr;
    read_ = shared_.exchange(read_, std::memory_order_acq_rel) & kIndex;
    return &slots_[read_];
  }

 private:
  static constexpr std::uint32_t kIndex = 3;
  static constexpr std::uint32_t kUnread = 4;

  std::array<T, 3> slots_;
  std::uint32_t draft_ = 0;               // writer only
  std::atomic<std::uint32_t> shared_{1};  // shared: an index, and whether that slot is unread
  std::uint32_t read_ = 2;                // reader only
  Doorbell& reader_bell_;
};

}  // namespace fanlight
