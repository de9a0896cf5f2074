// SPDX-License-Identifier: Apache-2.0
// Replaces operator new of the program.
#include "tests/out_of_memory/failing_new.hpp"

#include <atomic>
#include <cstdlib>
#include <new>

namespace fanlight::test {

namespace {

std::atomic<std::uint32_t> one_in_n = 0;
std::atomic<std::uint32_t> state = 1;
std::atomic<std::uint64_t> failed = 0;
thread_local int spared = 0;

/// Linear congruential generator of Numerical Recipes; its upper bits.
std::uint32_t draw() {
  std::uint32_t before = state.load();
  while (!state.compare_exchange_weak(before, 1'664'525 * before + 1'013'904'223)) {
  }
  return before >> 8;
}

bool fails(std::size_t bytes) {
  const std::uint32_t one_in = one_in_n.load();
  if (one_in == 0 || bytes < kSmallBytes || spared > 0 || draw() % one_in != 0) return false;
  ++failed;
  return true;
}

void* allocate(std::size_t bytes) {
  void* const memory = fails(bytes) ? nullptr : std::malloc(bytes == 0 ? 1 : bytes);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace

void fail_allocations(std::uint32_t one_in, std::uint32_t seed) {
  state = seed;
  one_in_n = one_in;
}

std::uint64_t failed_allocations() {
  return failed;
}

HasMemory::HasMemory() {
  ++spared;
}
HasMemory::~HasMemory() {
  --spared;
}

}  // namespace fanlight::test

void* operator new(std::size_t bytes) {
  return fanlight::test::allocate(bytes);
}
void* operator new[](std::size_t bytes) {
  return fanlight::test::allocate(bytes);
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete[](void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t /*bytes*/) noexcept {
  std::free(memory);
}
void operator delete[](void* memory, std::size_t /*bytes*/) noexcept {
  std::free(memory);
}
