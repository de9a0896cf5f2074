// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdio>
#include <cstdlib>

namespace fanlight::test {

/// Prints the condition and aborts the process if it does not hold. libFuzzer reports an abort as a finding.
inline void require(bool holds, const char* condition) {
  if (holds) return;
  std::fprintf(stderr, "does not hold: %s\n", condition);
  std::abort();
}

}  // namespace fanlight::test
