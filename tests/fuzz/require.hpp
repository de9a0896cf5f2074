#pragma once

#include <cstdio>
#include <cstdlib>

namespace fanlight::test {

/// Ends the process where something does not hold, which is what a fuzzer looks for.
inline void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "does not hold: %s\n", what);
  std::abort();
}

}  // namespace fanlight::test
