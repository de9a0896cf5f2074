// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "proto/base/result.hpp"

namespace fanlight {

/// What a sender reports of itself (RFC 3550, section 6.4.1).
struct SenderReport {
  std::uint32_t source = 0;  ///< SSRC
  std::uint64_t ntp = 0;  ///< time of day: seconds since 1900 in the upper half, parts of 2^32 in the lower
  std::uint32_t timestamp = 0;  ///< the same moment on the clock of the RTP packets
  std::uint32_t packets = 0;    ///< sent so far; wraps
  std::uint32_t bytes = 0;      ///< of their payloads; wraps
};

/// The time of day as in SenderReport.
std::uint64_t ntp_time(std::uint64_t utc_ns);

/// A compound packet: the report and the source's name, without reports of reception; `name` has at most 255
/// bytes. `ends`: with a BYE.
std::vector<std::uint8_t> rtcp_packet(const SenderReport& report, std::string_view name, bool ends);

/// What a receiver reports of our stream (RFC 3550, section 6.4.2).
struct ReceptionReport {
  double lost_share = 0;          ///< of the packets since its last report, 0 to 1
  std::int32_t lost = 0;          ///< packets in all; duplicates may make it negative
  std::uint32_t jitter = 0;       ///< in units of the RTP clock
  std::uint32_t last_report = 0;  ///< middle of SenderReport::ntp of our last report that it got; 0: none
  std::uint32_t since_last_report = 0;  ///< and how long ago, in units of 1/65536 s
};

/// What came in one compound packet.
struct RtcpFeedback {
  std::optional<ReceptionReport> report;
  bool key_wanted = false;           ///< PLI (RFC 4585) or FIR (RFC 5104)
  std::uint32_t packets_wanted = 0;  ///< that a NACK (RFC 4585) asks for again; they are not sent again
  bool ends = false;                 ///< a BYE of a receiver
};

/// Reads a compound packet, or one of reduced size (RFC 5506). Reports of other sources than ours are passed
/// over; a request for a key picture counts whatever source it names, as there is only one. kBadInput: it is
/// no RTCP, or a length in it is wrong.
Result<RtcpFeedback> parse_rtcp(std::span<const std::uint8_t> packet, std::uint32_t our_source);

}  // namespace fanlight
