// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace fanlight {

/// What a receiver needs to know of the stream before its first packet.
struct RtpDescription {
  std::string title;                             ///< of the source
  std::string from;                              ///< address of this machine, as text
  std::string to;                                ///< where the packets go
  bool v6 = false;                               ///< both are of IPv6
  std::uint16_t port = 0;                        ///< RTCP goes to the next one
  std::uint32_t source = 0;                      ///< SSRC
  std::uint64_t session = 0;                     ///< number of this stream
  std::uint64_t version = 1;                     ///< of this description; raised with each change
  std::string name;                              ///< CNAME
  std::span<const std::uint8_t> sequence_set{};  ///< NAL units of the encoder; empty before the first picture
  std::span<const std::uint8_t> picture_set{};
  std::span<const std::uint8_t> srtp_key{};  ///< empty: not encrypted
};

inline constexpr std::uint8_t kRtpPayloadType = 96;  // dynamic, as all of H.264

/// A session description (RFC 8866) with the parameters of RFC 6184, for a receiver at RtpDescription::to.
/// With a key it holds a secret (RFC 4568).
std::string sdp(const RtpDescription& description);

}  // namespace fanlight
