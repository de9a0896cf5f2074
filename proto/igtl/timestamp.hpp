// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace fanlight::igtl {

/// OpenIGTLink's times: seconds since 1970-01-01 UTC in the upper 32 bits, and their fraction in the lower
/// ones, in units of 2^-32 s (OpenIGTLink, Documents/Protocol/timestamp.md).
constexpr std::uint64_t kNsInS = 1'000'000'000;

/// ns since 1970; below 2^63, until the year 2106.
constexpr std::uint64_t ns_of(std::uint64_t timestamp) {
  const std::uint64_t fraction = timestamp & 0xFFFF'FFFF;
  return (timestamp >> 32) * kNsInS + ((fraction * kNsInS + (std::uint64_t{1} << 31)) >> 32);
}

constexpr std::uint64_t timestamp_of(std::uint64_t ns) {
  const std::uint64_t fraction = ((ns % kNsInS) << 32) / kNsInS;
  return (ns / kNsInS) << 32 | fraction;
}

}  // namespace fanlight::igtl
