// The C library's memory functions, looked at first. operator new and delete, and all that libraries
// allocate, come through them.
#include <malloc.h>

#include <cerrno>
#include <cstdlib>

#include "tests/hot_path/hot_threads.hpp"

using fanlight::test::look_at;

extern "C" {

// glibc's own names of what is interposed here.
void* __libc_malloc(std::size_t bytes);
void* __libc_calloc(std::size_t count, std::size_t bytes);
void* __libc_realloc(void* memory, std::size_t bytes);
void* __libc_memalign(std::size_t alignment, std::size_t bytes);
void __libc_free(void* memory);

void* malloc(std::size_t bytes) noexcept {
  look_at("malloc", __builtin_return_address(0));
  return __libc_malloc(bytes);
}

void* calloc(std::size_t count, std::size_t bytes) noexcept {
  look_at("calloc", __builtin_return_address(0));
  return __libc_calloc(count, bytes);
}

void* realloc(void* memory, std::size_t bytes) noexcept {
  look_at("realloc", __builtin_return_address(0));
  return __libc_realloc(memory, bytes);
}

void* memalign(std::size_t alignment, std::size_t bytes) noexcept {
  look_at("memalign", __builtin_return_address(0));
  return __libc_memalign(alignment, bytes);
}

void* aligned_alloc(std::size_t alignment, std::size_t bytes) noexcept {
  look_at("aligned_alloc", __builtin_return_address(0));
  return __libc_memalign(alignment, bytes);
}

int posix_memalign(void** memory, std::size_t alignment, std::size_t bytes) noexcept {
  look_at("posix_memalign", __builtin_return_address(0));
  *memory = __libc_memalign(alignment, bytes);
  return *memory == nullptr ? ENOMEM : 0;
}

void free(void* memory) noexcept {
  // Of nothing it does nothing.
  if (memory != nullptr) look_at("free", __builtin_return_address(0));
  __libc_free(memory);
}

}  // extern "C"
