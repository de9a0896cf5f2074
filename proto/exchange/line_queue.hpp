// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

namespace fanlight {

/// Lines of text on their way from one writer thread to one reader thread. Beyond the capacity further ones
/// are dropped. Never locks or blocks; the text is moved.
class LineQueue {
 public:
  /// Writer. False where the queue is full.
  bool put(std::string line) {
    const std::uint64_t put = put_.load(std::memory_order_relaxed);
    if (put - taken_.load(std::memory_order_acquire) == lines_.size()) return false;
    lines_[put % lines_.size()] = std::move(line);
    put_.store(put + 1, std::memory_order_release);
    return true;
  }
  /// Reader: the oldest; nullopt: none.
  std::optional<std::string> take() {
    const std::uint64_t taken = taken_.load(std::memory_order_relaxed);
    if (taken == put_.load(std::memory_order_acquire)) return std::nullopt;
    std::string line = std::move(lines_[taken % lines_.size()]);
    taken_.store(taken + 1, std::memory_order_release);
    return line;
  }

 private:
  std::array<std::string, 256> lines_;
  std::atomic<std::uint64_t> put_{0};
  std::atomic<std::uint64_t> taken_{0};
};

}  // namespace fanlight
