// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

namespace fanlight {

/// CRC-64 of ECMA-182 annex B, as OpenIGTLink uses it: polynomial 0x42F0E1EBA9EA3693, most significant bit
/// first, initial value 0, no final exclusive-or: "123456789" gives 0x6C40DF5F0B497347. `before`: the value
/// of the bytes before these.
std::uint64_t crc64(std::span<const std::uint8_t> bytes, std::uint64_t before = 0);

}  // namespace fanlight
