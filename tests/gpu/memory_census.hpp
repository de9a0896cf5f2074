// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace fanlight::test {

/// Counts the GPU memory of this program: intercepts its calls of vkAllocateMemory and vkFreeMemory. Memory
/// that layers and drivers allocate for themselves does not count.
struct MemoryCensus {
  std::uint64_t taken = 0;  ///< allocations ever made
  std::uint64_t held = 0;   ///< allocations that are not freed yet
  std::uint64_t held_bytes = 0;

  bool operator==(const MemoryCensus&) const = default;

  /// The present counts. Any thread.
  static MemoryCensus now();
};

}  // namespace fanlight::test
