// SPDX-License-Identifier: Apache-2.0
// Entry point of libFuzzer. Compiled once for each function of fuzz_targets.hpp; the macro
// FANLIGHT_FUZZ_TARGET is the name of the function.
#include "tests/fuzz/fuzz_targets.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fanlight::test::FANLIGHT_FUZZ_TARGET({data, size});
  return 0;
}
