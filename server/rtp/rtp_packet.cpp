// SPDX-License-Identifier: Apache-2.0
#include "server/rtp/rtp_packet.hpp"

namespace fanlight {

void put_u16(std::vector<std::uint8_t>& bytes, std::uint16_t value) {
  bytes.push_back(static_cast<std::uint8_t>(value >> 8));
  bytes.push_back(static_cast<std::uint8_t>(value & 255));
}

void put_u32(std::vector<std::uint8_t>& bytes, std::uint32_t value) {
  put_u16(bytes, static_cast<std::uint16_t>(value >> 16));
  put_u16(bytes, static_cast<std::uint16_t>(value & 0xffff));
}

void put_rtp_header(std::vector<std::uint8_t>& bytes, const RtpHeader& header) {
  constexpr std::uint8_t kVersionBits = 0x80;
  bytes.push_back(kVersionBits);
  bytes.push_back(static_cast<std::uint8_t>((header.marker ? 0x80 : 0) | (header.payload_type & 0x7f)));
  put_u16(bytes, header.sequence);
  put_u32(bytes, header.timestamp);
  put_u32(bytes, header.source);
}

}  // namespace fanlight
