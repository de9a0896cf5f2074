#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "proto/doorbell.hpp"

namespace fanlight {

/// One writer thread leaves the newest T for one reader thread; an unread older one is replaced. Three
/// slots, so neither side ever waits, locks or allocates (T's own memory is reused: fill draft() in place).
template <typename T>
class Mailbox {
 public:
  /// Each publish rings `reader_bell`, which must outlive the mailbox. `initial` fills all three slots, so
  /// that a T with buffers gets them all here.
  explicit Mailbox(Doorbell& reader_bell, const T& initial = T{})
      : slots_{initial, initial, initial}, reader_bell_(reader_bell) {}

  /// Writer thread: the slot to fill next. It holds an older value whose memory may be reused.
  T& draft() { return slots_[draft_]; }

  /// Writer thread: makes draft() the newest. True where it replaced a value that was never read.
  bool publish() {
    const std::uint32_t previous = shared_.exchange(draft_ | kUnread, std::memory_order_acq_rel);
    draft_ = previous & kIndex;
    reader_bell_.ring();
    return (previous & kUnread) != 0;
  }

  /// Reader thread: the newest value, or nullptr where none came since the last call. Valid until the next
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
  std::uint32_t draft_ = 0;               // writer's
  std::atomic<std::uint32_t> shared_{1};  // between them: an index, and whether it is unread
  std::uint32_t read_ = 2;                // reader's
  Doorbell& reader_bell_;
};

}  // namespace fanlight
