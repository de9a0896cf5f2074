// SPDX-License-Identifier: Apache-2.0
#include "server/rtp/sdp.hpp"

#include <fmt/format.h>
#include <openssl/evp.h>

#include "server/rtp/rtp_clock.hpp"

namespace fanlight {

namespace {

std::string base64(std::span<const std::uint8_t> bytes) {
  std::vector<unsigned char> text((bytes.size() + 2) / 3 * 4 + 1);
  const int letters = EVP_EncodeBlock(text.data(), bytes.data(), static_cast<int>(bytes.size()));
  return {text.begin(), text.begin() + letters};
}

/// A title may have any letters but line ends.
std::string one_line(std::string text) {
  for (char& letter : text) {
    if (static_cast<unsigned char>(letter) < ' ') letter = ' ';
  }
  return text.empty() ? "Fanlight" : text;
}

}  // namespace

std::string sdp(const RtpDescription& description) {
  const char* const family = description.v6 ? "IP6" : "IP4";
  const bool encrypted = !description.srtp_key.empty();
  std::string text = "v=0\r\n";
  text += fmt::format("o=- {} {} IN {} {}\r\n", description.session, description.version, family,
                      description.from);
  text += fmt::format("s={}\r\n", one_line(description.title));
  text += fmt::format("c=IN {} {}\r\n", family, description.to);
  text += "t=0 0\r\n";
  text += fmt::format("m=video {} RTP/{} {}\r\n", description.port, encrypted ? "SAVPF" : "AVPF",
                      kRtpPayloadType);
  text += fmt::format("a=rtpmap:{} H264/{}\r\n", kRtpPayloadType, kRtpClockHz);
  text += fmt::format("a=fmtp:{} packetization-mode=1", kRtpPayloadType);
  // Profile, constraints and level are the three bytes after the head of the sequence parameter set.
  if (description.sequence_set.size() >= 4 && !description.picture_set.empty()) {
    text += fmt::format(";profile-level-id={:02X}{:02X}{:02X};sprop-parameter-sets={},{}",
                        description.sequence_set[1], description.sequence_set[2], description.sequence_set[3],
                        base64(description.sequence_set), base64(description.picture_set));
  }
  text += "\r\n";
  text += fmt::format("a=rtcp:{}\r\n", description.port + 1);
  text += fmt::format("a=rtcp-fb:{} nack pli\r\na=rtcp-fb:{} ccm fir\r\n", kRtpPayloadType, kRtpPayloadType);
  text += fmt::format("a=ssrc:{} cname:{}\r\n", description.source, description.name);
  if (encrypted)
    text += fmt::format("a=crypto:1 AES_CM_128_HMAC_SHA1_80 inline:{}\r\n", base64(description.srtp_key));
  return text;
}

}  // namespace fanlight
