// SPDX-License-Identifier: Apache-2.0
#include "proto/base/crc64.hpp"

#include <isa-l/crc64.h>

#include "proto/base/vector_state.hpp"

namespace fanlight {

std::uint64_t crc64(std::span<const std::uint8_t> bytes, std::uint64_t before) {
  // The library inverts the value before and after.
  const std::uint64_t value = ~crc64_ecma_norm(~before, bytes.data(), bytes.size());
  end_vector_code();
  return value;
}

}  // namespace fanlight
