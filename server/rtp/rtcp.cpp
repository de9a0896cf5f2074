// SPDX-License-Identifier: Apache-2.0
#include "server/rtp/rtcp.hpp"

#include <bit>

#include "server/rtp/rtp_packet.hpp"

namespace fanlight {

namespace {

using Bytes = std::span<const std::uint8_t>;

// Kinds of packets (RFC 3550, section 12.1; RFC 4585, section 6.1).
enum Kind : std::uint8_t {
  kSenderReport = 200,
  kReceiverReport = 201,
  kDescription = 202,
  kBye = 203,
  kTransportFeedback = 205,
  kPayloadFeedback = 206,
};
constexpr std::uint8_t kVersion2 = 0x80;
constexpr std::uint8_t kNack = 1;         // of transport feedback
constexpr std::uint8_t kPictureLoss = 1;  // of payload feedback
constexpr std::uint8_t kFullIntra = 4;    // of payload feedback
constexpr std::size_t kHeaderBytes = 4;
constexpr std::size_t kReportBlockBytes = 24;
constexpr std::size_t kSenderInfoBytes = 20;

void put_header(std::vector<std::uint8_t>& bytes, std::uint8_t count, Kind kind, std::size_t body_bytes) {
  bytes.push_back(kVersion2 | count);
  bytes.push_back(kind);
  put_u16(bytes, static_cast<std::uint16_t>(body_bytes / 4));
}

std::uint32_t u32_at(Bytes bytes, std::size_t at) {
  return static_cast<std::uint32_t>(bytes[at]) << 24 | static_cast<std::uint32_t>(bytes[at + 1]) << 16 |
         static_cast<std::uint32_t>(bytes[at + 2]) << 8 | bytes[at + 3];
}

Error malformed(const char* wrong) {
  return {ErrorCode::kBadInput, wrong};
}

/// `blocks`: report blocks, `count` of them.
void read_reports(RtcpFeedback& feedback, Bytes blocks, std::size_t count, std::uint32_t our_source) {
  for (std::size_t block = 0; block < count; ++block) {
    const Bytes bytes = blocks.subspan(block * kReportBlockBytes, kReportBlockBytes);
    if (u32_at(bytes, 0) != our_source) continue;
    const std::uint32_t lost = u32_at(bytes, 4);
    feedback.report = ReceptionReport{.lost_share = (lost >> 24) / 256.0,
                                      // 24 bits with a sign.
                                      .lost = static_cast<std::int32_t>(lost << 8) >> 8,
                                      .jitter = u32_at(bytes, 12),
                                      .last_report = u32_at(bytes, 16),
                                      .since_last_report = u32_at(bytes, 20)};
  }
}

/// `body`: after the header and without padding.
Result<void> read_one(RtcpFeedback& feedback, std::uint8_t kind, std::uint8_t count, Bytes body,
                      std::uint32_t our_source) {
  if (kind == kSenderReport || kind == kReceiverReport) {
    const std::size_t before = 4 + (kind == kSenderReport ? kSenderInfoBytes : 0);
    if (body.size() < before + count * kReportBlockBytes)
      return malformed("a report is shorter than it says");
    read_reports(feedback, body.subspan(before), count, our_source);
  } else if (kind == kPayloadFeedback || kind == kTransportFeedback) {
    if (body.size() < 8) return malformed("feedback is shorter than its head");
    if (kind == kPayloadFeedback && (count == kPictureLoss || count == kFullIntra))
      feedback.key_wanted = true;
    if (kind == kTransportFeedback && count == kNack) {
      // Each entry names one packet, and in 16 bits those of the next 16 that are lost too.
      for (std::size_t at = 8; at + 4 <= body.size(); at += 4)
        feedback.packets_wanted += 1 + static_cast<std::uint32_t>(std::popcount(u32_at(body, at) & 0xffff));
    }
  } else if (kind == kBye) {
    feedback.ends = true;
  }
  return {};
}

}  // namespace

std::uint64_t ntp_time(std::uint64_t utc_ns) {
  constexpr std::uint64_t kFrom1900To1970 = 2'208'988'800;
  constexpr std::uint64_t kSecond = 1'000'000'000;
  return (utc_ns / kSecond + kFrom1900To1970) << 32 | ((utc_ns % kSecond) << 32) / kSecond;
}

std::vector<std::uint8_t> rtcp_packet(const SenderReport& report, std::string_view name, bool ends) {
  std::vector<std::uint8_t> bytes;
  put_header(bytes, 0, kSenderReport, 4 + kSenderInfoBytes);
  put_u32(bytes, report.source);
  put_u32(bytes, static_cast<std::uint32_t>(report.ntp >> 32));
  put_u32(bytes, static_cast<std::uint32_t>(report.ntp & 0xffffffff));
  put_u32(bytes, report.timestamp);
  put_u32(bytes, report.packets);
  put_u32(bytes, report.bytes);
  // One chunk with one item, the name, that ends with one to four zero bytes at a whole word.
  constexpr std::uint8_t kName = 1;
  const std::size_t item_bytes = 2 + name.size();
  const std::size_t chunk_bytes = 4 + (item_bytes / 4 + 1) * 4;
  put_header(bytes, 1, kDescription, chunk_bytes);
  put_u32(bytes, report.source);
  bytes.push_back(kName);
  bytes.push_back(static_cast<std::uint8_t>(name.size()));
  bytes.insert(bytes.end(), name.begin(), name.end());
  bytes.insert(bytes.end(), chunk_bytes - 4 - item_bytes, 0);
  if (ends) {
    put_header(bytes, 1, kBye, 4);
    put_u32(bytes, report.source);
  }
  return bytes;
}

Result<RtcpFeedback> parse_rtcp(Bytes packet, std::uint32_t our_source) {
  RtcpFeedback feedback;
  if (packet.empty()) return malformed("it is empty");
  while (!packet.empty()) {
    if (packet.size() < kHeaderBytes) return malformed("it ends within a header");
    if ((packet[0] & 0xc0) != kVersion2) return malformed("its version is not 2");
    const std::uint8_t kind = packet[1];
    if (kind < kSenderReport || kind > 223)
      return malformed("it is of no kind of RTCP");  // RFC 5761, section 4
    const std::size_t bytes = 4 * (std::size_t{1} + packet[2] * 256U + packet[3]);
    if (bytes > packet.size()) return malformed("a packet is longer than the datagram");
    Bytes body = packet.subspan(kHeaderBytes, bytes - kHeaderBytes);
    if ((packet[0] & 0x20) != 0) {
      if (body.empty() || body.back() == 0 || body.back() > body.size())
        return malformed("its padding is wrong");
      body = body.first(body.size() - body.back());
    }
    if (auto read = read_one(feedback, kind, packet[0] & 31, body, our_source); !read) return read.error();
    packet = packet.subspan(bytes);
  }
  return feedback;
}

}  // namespace fanlight
