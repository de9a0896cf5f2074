// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace fanlight::test {

/// Resources that this process uses now.
struct Resources {
  std::size_t files = 0;  ///< open file descriptors
  std::size_t threads = 0;
  double resident_mb = 0;
  double heap_mb = 0;  ///< allocated and not freed

  static Resources now();
};

}  // namespace fanlight::test
