// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

namespace fanlight::test {

/// Smaller allocations never fail: they find room in memory that the process has already, and protobuf's
/// messages are not made for a failure in the midst of a small one (a repeated field then crashes).
inline constexpr std::size_t kSmallBytes = 1024;

/// Lets operator new fail in all threads but those that hold a HasMemory: each time with a probability of
/// one in `one_in`; 0: never. The sequence of draws is that of the seed.
void fail_allocations(std::uint32_t one_in, std::uint32_t seed);

/// Number of allocations that failed so far.
std::uint64_t failed_allocations();

/// While one exists, the allocations of its thread succeed.
class HasMemory {
 public:
  HasMemory();
  ~HasMemory();
  HasMemory(const HasMemory&) = delete;
  HasMemory& operator=(const HasMemory&) = delete;
};

}  // namespace fanlight::test
