// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>

namespace fanlight {

/// Counts how often the loop of a thread comes round, so that a watchdog sees a loop that stands still. A
/// loop that waits for its Doorbell comes round once a second at least. Written by that thread, read by any.
class Pulse {
 public:
  /// The calling thread beats for this pulse, until the object ends. One for each thread.
  class OfThisThread {
   public:
    explicit OfThisThread(Pulse& pulse) { current = &pulse; }
    ~OfThisThread() { current = nullptr; }
    OfThisThread(const OfThisThread&) = delete;
    OfThisThread& operator=(const OfThisThread&) = delete;
  };

  /// The calling thread's loop has come round. Does nothing in a thread without a pulse. Does not block.
  static void beat() {
    if (current != nullptr) current->beats_.fetch_add(1, std::memory_order_relaxed);
  }

  std::uint64_t beats() const { return beats_.load(std::memory_order_relaxed); }

 private:
  static inline thread_local Pulse* current = nullptr;
  std::atomic<std::uint64_t> beats_{0};
};

}  // namespace fanlight
