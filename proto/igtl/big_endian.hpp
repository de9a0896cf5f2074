// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstdint>
#include <span>
#include <vector>

namespace fanlight::igtl {

/// The number at the begin of `bytes`, most significant byte first. Precondition: there are enough.
template <std::unsigned_integral T>
T big_endian(std::span<const std::uint8_t> bytes) {
  std::uint64_t number = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) number = number << 8 | bytes[i];
  return static_cast<T>(number);
}

/// Appends a number, most significant byte first.
template <std::unsigned_integral T>
void put_big_endian(std::vector<std::uint8_t>& bytes, T number) {
  for (std::size_t i = sizeof(T); i-- > 0;)
    bytes.push_back(static_cast<std::uint8_t>(std::uint64_t{number} >> (8 * i)));
}

}  // namespace fanlight::igtl
