// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

namespace fanlight {

/// The fixed header of an RTP packet (RFC 3550, section 5.1), without extension and contributing sources.
struct RtpHeader {
  std::uint8_t payload_type = 0;  ///< 0 to 127
  bool marker = false;            ///< the last packet of a picture
  std::uint16_t sequence = 0;
  std::uint32_t timestamp = 0;  ///< in units of the payload's clock
  std::uint32_t source = 0;     ///< SSRC
};
inline constexpr std::size_t kRtpHeaderBytes = 12;

/// Appends the header.
void put_rtp_header(std::vector<std::uint8_t>& bytes, const RtpHeader& header);

/// Appends numbers, most significant byte first.
void put_u16(std::vector<std::uint8_t>& bytes, std::uint16_t value);
void put_u32(std::vector<std::uint8_t>& bytes, std::uint32_t value);

}  // namespace fanlight
