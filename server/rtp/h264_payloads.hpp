// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace fanlight {

/// Kinds of NAL units (H.264, table 7-1) that matter here.
enum class NalKind : std::uint8_t { kSlice = 1, kKeySlice = 5, kSei = 6, kSequenceSet = 7, kPictureSet = 8 };

inline NalKind nal_kind(std::span<const std::uint8_t> unit) {
  return static_cast<NalKind>(unit.empty() ? 0 : unit.front() & 31);
}

/// The NAL units of a byte stream with start codes (H.264, annex B), without those codes, in order. Empty
/// units are left out. They are valid as long as `stream`.
std::vector<std::span<const std::uint8_t>> nal_units(std::span<const std::uint8_t> stream);

/// The NAL units of one picture as RTP payloads (RFC 6184, packetization mode 1): small units that follow
/// each other share one (STAP-A), a unit that is too large is cut in even parts (FU-A). Each has at most
/// `most_bytes` bytes, which must be 64 or more.
std::vector<std::vector<std::uint8_t>> h264_payloads(std::span<const std::span<const std::uint8_t>> units,
                                                     std::size_t most_bytes);

}  // namespace fanlight
