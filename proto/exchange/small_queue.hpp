// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

namespace fanlight {

/// Values on their way from one writer thread to one reader thread, in their order. Beyond the capacity
/// further ones are refused. Never locks or blocks; allocates only where T does.
template <typename T, std::size_t kCapacity>
class SmallQueue {
 public:
  /// Writer: how many values can be put.
  std::size_t room() const {
    return kCapacity - static_cast<std::size_t>(put_.load(std::memory_order_relaxed) -
                                                taken_.load(std::memory_order_acquire));
  }
  /// Writer. False where the queue is full.
  bool put(T value) {
    const std::uint64_t put = put_.load(std::memory_order_relaxed);
    if (put - taken_.load(std::memory_order_acquire) == values_.size()) return false;
    values_[put % values_.size()] = std::move(value);
    put_.store(put + 1, std::memory_order_release);
    return true;
  }
  /// Reader.
  bool empty() const {
    return taken_.load(std::memory_order_relaxed) == put_.load(std::memory_order_acquire);
  }
  /// Reader: the oldest; nullopt: none.
  std::optional<T> take() {
    const std::uint64_t taken = taken_.load(std::memory_order_relaxed);
    if (taken == put_.load(std::memory_order_acquire)) return std::nullopt;
    std::optional<T> value(std::move(values_[taken % values_.size()]));
    taken_.store(taken + 1, std::memory_order_release);
    return value;
  }

 private:
  std::array<T, kCapacity> values_{};
  std::atomic<std::uint64_t> put_{0};
  std::atomic<std::uint64_t> taken_{0};
};

}  // namespace fanlight
