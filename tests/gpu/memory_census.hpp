#pragma once

#include <cstdint>

namespace fanlight::test {

/// All GPU memory that this program holds and ever took: its calls of vkAllocateMemory and vkFreeMemory are
/// counted on their way to the loader. What layers and drivers take for themselves is not in it.
struct MemoryCensus {
  std::uint64_t taken = 0;  ///< allocations ever made
  std::uint64_t held = 0;   ///< of these, not yet given back
  std::uint64_t held_bytes = 0;

  bool operator==(const MemoryCensus&) const = default;

  /// As it is now. Any thread.
  static MemoryCensus now();
};

}  // namespace fanlight::test
