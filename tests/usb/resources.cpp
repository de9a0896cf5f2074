// SPDX-License-Identifier: Apache-2.0
#include "tests/usb/resources.hpp"

#include <malloc.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace fanlight::test {

namespace {

std::size_t entries(const char* folder) {
  const std::filesystem::directory_iterator files(folder);
  return static_cast<std::size_t>(std::distance(begin(files), end(files)));
}

}  // namespace

Resources Resources::now() {
  malloc_trim(0);  // memory that is free but kept by the allocator does not count
  const struct mallinfo2 heap = mallinfo2();
  std::size_t pages = 0;
  std::size_t resident_pages = 0;
  std::ifstream("/proc/self/statm") >> pages >> resident_pages;
  const auto page_bytes = static_cast<double>(sysconf(_SC_PAGESIZE));
  return {.files = entries("/proc/self/fd"),
          .threads = entries("/proc/self/task"),
          .resident_mb = static_cast<double>(resident_pages) * page_bytes / 1e6,
          .heap_mb = static_cast<double>(heap.uordblks + heap.hblkhd) / 1e6};
}

}  // namespace fanlight::test
