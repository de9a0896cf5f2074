// SPDX-License-Identifier: Apache-2.0
#include "proto/base/crc32c.hpp"

#include <isa-l/crc.h>

#include <algorithm>

namespace fanlight {

namespace {

/// isa-l 2.30 leaves the upper halves of the AVX registers set where it uses AVX-512. Each SSE instruction of
/// this thread would then have to keep them: filling a grid of distances took 11.6 s instead of 0.8 s.
#if defined(__x86_64__)
__attribute__((target("avx"))) void clear_upper_halves() {
  __builtin_ia32_vzeroupper();
}
void end_vector_code() {
  if (__builtin_cpu_supports("avx")) clear_upper_halves();
}
#else
void end_vector_code() {}
#endif

}  // namespace

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
