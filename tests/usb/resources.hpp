#pragma once

#include <cstddef>

namespace fanlight::test {

/// What this process holds of the machine now.
struct Resources {
  std::size_t files = 0;  ///< open file descriptors
  std::size_t threads = 0;
  double resident_mb = 0;
  double heap_mb = 0;  ///< allocated and not freed

  static Resources now();
};

}  // namespace fanlight::test
