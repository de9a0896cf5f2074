// SPDX-License-Identifier: Apache-2.0
// Interposes the memory functions of the C library. operator new and delete, and the allocations of all
// libraries, use them.
#include <malloc.h>

#include <cerrno>
#include <cstdlib>

#include "tests/hot_path/hot_threads.hpp"

using fanlight::test::check_call;

extern "C" {

// glibc's internal names of the interposed functions.
void* __libc_malloc(std::size_t bytes);
void* __libc_calloc(std::size_t count, std::size_t bytes);
void* __libc_realloc(void* memory, std::size_t bytes);
void* __libc_memalign(std::size_t alignment, std::size_t bytes);
void __libc_free(void* memory);

void* malloc(std::size_t bytes) noexcept {
  check_call("malloc", __builtin_return_address(0));
  return __libc_malloc(bytes);
}

void* calloc(std::size_t count, std::size_t bytes) noexcept {
  check_call("calloc", __builtin_return_address(0));
  return __libc_calloc(count, bytes);
}

void* realloc(void* memory, std::size_t bytes) noexcept {
  check_call("realloc", __builtin_return_address(0));
  return __libc_realloc(memory, bytes);
}

void* memalign(std::size_t alignment, std::size_t bytes) noexcept {
  check_call("memalign", __builtin_return_address(0));
  return __libc_memalign(alignment, bytes);
}

void* aligned_alloc(std::size_t alignment, std::size_t bytes) noexcept {
  check_call("aligned_alloc", __builtin_return_address(0));
  return __libc_memalign(alignment, bytes);
}

int posix_memalign(void** memory, std::size_t alignment, std::size_t bytes) noexcept {
  check_call("posix_memalign", __builtin_return_address(0));
  *memory = __libc_memalign(alignment, bytes);
  return *memory == nullptr ? ENOMEM : 0;
}

void free(void* memory) noexcept {
  // free(nullptr) does nothing.
  if (memory != nullptr) check_call("free", __builtin_return_address(0));
  __libc_free(memory);
}

}  // extern "C"
