// One fuzzer for libFuzzer: compiled once for each function of fuzz_targets.hpp, named by
// FANLIGHT_FUZZ_TARGET.
#include "tests/fuzz/fuzz_targets.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fanlight::test::FANLIGHT_FUZZ_TARGET({data, size});
  return 0;
}
