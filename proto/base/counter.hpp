// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>

namespace fanlight {

/// A count. One thread increments it, any thread reads it.
class Counter {
 public:
  void add(std::uint64_t amount = 1) { value_.fetch_add(amount, std::memory_order_release); }
  std::uint64_t value() const { return value_.load(std::memory_order_acquire); }

 private:
  std::atomic<std::uint64_t> value_{0};
};

/// A value. One thread sets it, any thread reads it.
template <typename T>
class Gauge {
 public:
  void set(T value) { value_.store(value, std::memory_order_release); }
  T value() const { return value_.load(std::memory_order_acquire); }

 private:
  std::atomic<T> value_{};
};

/// A sequence lock over several counters. Readers see all changes of an entry or none of them, so that sums
/// over the counters hold at any moment. One thread writes, any thread reads. The writer never waits. The
/// release and acquire order of the counters orders them against the lock.
class SeqLock {
 public:
  /// Writer thread. Readers wait while an entry exists. Entries may nest.
  class Entry {
   public:
    explicit Entry(SeqLock& seq_lock) : seq_lock_(seq_lock) {
      if (seq_lock_.depth_++ == 0) seq_lock_.turn_.fetch_add(1, std::memory_order_release);
    }
    ~Entry() {
      if (--seq_lock_.depth_ == 0) seq_lock_.turn_.fetch_add(1, std::memory_order_release);
    }
    Entry(const Entry&) = delete;
    Entry& operator=(const Entry&) = delete;

   private:
    SeqLock& seq_lock_;
  };

  /// Any thread. Calls `read` again until no entry existed during the call. `read` must only copy counters.
  template <typename Read>
  void read(Read&& read) const {
    for (;;) {
      const std::uint64_t before = turn_.load(std::memory_order_acquire);
      read();
      if (before % 2 == 0 && turn_.load(std::memory_order_acquire) == before) return;
    }
  }

 private:
  std::atomic<std::uint64_t> turn_{0};  // odd while an entry exists
  int depth_ = 0;                       // of nested entries; writer thread only
};

}  // namespace fanlight
