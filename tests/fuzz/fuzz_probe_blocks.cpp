#include "proto/probe_protocol.hpp"
#include "tests/fuzz/fuzz_targets.hpp"
#include "tests/fuzz/require.hpp"

namespace fanlight::test {

namespace {

template <typename T>
void check_block(const Result<T>& read, Result<T> (*decode)(std::span<const std::uint8_t>)) {
  if (!read) {
    require(!read.error().message.empty(), "a refusal has a sentence");
    return;
  }
  const auto again = decode(probe::encode(*read));
  require(again.has_value() && *again == *read, "what was read encodes to the same again");
}

}  // namespace

void fuzz_probe_blocks(std::span<const std::uint8_t> input) {
  check_block(probe::decode_identity(input), &probe::decode_identity);
  check_block(probe::decode_capabilities(input), &probe::decode_capabilities);
  check_block(probe::decode_geometry(input), &probe::decode_geometry);
  check_block(probe::decode_settings(input), &probe::decode_settings);
}

}  // namespace fanlight::test
