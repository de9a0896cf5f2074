// SPDX-License-Identifier: Apache-2.0
#include "proto/model/probe_protocol.hpp"
#include "tests/fuzz/fuzz_targets.hpp"
#include "tests/fuzz/require.hpp"

namespace fanlight::test {

namespace {

template <typename T>
void check_block(const Result<T>& decoded, Result<T> (*decode)(std::span<const std::uint8_t>)) {
  if (!decoded) {
    require(!decoded.error().message.empty(), "a refusal has a message");
    return;
  }
  const auto again = decode(probe::encode(*decoded));
  require(again.has_value() && *again == *decoded,
          "a decoded block is unchanged after encoding and decoding");
}

}  // namespace

void fuzz_probe_blocks(std::span<const std::uint8_t> input) {
  check_block(probe::decode_identity(input), &probe::decode_identity);
  check_block(probe::decode_capabilities(input), &probe::decode_capabilities);
  check_block(probe::decode_geometry(input), &probe::decode_geometry);
  check_block(probe::decode_settings(input), &probe::decode_settings);
}

}  // namespace fanlight::test
