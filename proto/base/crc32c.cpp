// SPDX-License-Identifier: Apache-2.0
#include "proto/base/crc32c.hpp"

#include <isa-l/crc.h>

#include <algorithm>

#include "proto/base/vector_state.hpp"

namespace fanlight {

void Crc32c::add(std::span<const std::uint8_t> bytes) {
  constexpr std::size_t kMostAtOnce = 1U << 30;  // the library's length is an int
  while (!bytes.empty()) {
    const auto piece = bytes.first(std::min(bytes.size(), kMostAtOnce));
    // The library only reads; its interface lacks const.
    state_ = crc32_iscsi(const_cast<std::uint8_t*>(piece.data()), static_cast<int>(piece.size()), state_);
    bytes = bytes.subspan(piece.size());
  }
  end_vector_code();
}

}  // namespace fanlight
