// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

namespace fanlight {

/// CRC-32C of bytes that arrive in pieces (Castagnoli, RFC 3720 appendix B.4; reflected polynomial
/// 0x82F63B78, initial value and final exclusive-or 0xFFFFFFFF): "123456789" gives 0xE3069283. One thread.
class Crc32c {
 public:
  void add(std::span<const std::uint8_t> bytes);
  std::uint32_t value() const { return ~state_; }

 private:
  std::uint32_t state_ = 0xFFFFFFFF;
};

inline std::uint32_t crc32c(std::span<const std::uint8_t> bytes) {
  Crc32c crc;
  crc.add(bytes);
  return crc.value();
}

}  // namespace fanlight
