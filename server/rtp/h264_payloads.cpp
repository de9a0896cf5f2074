// SPDX-License-Identifier: Apache-2.0
#include "server/rtp/h264_payloads.hpp"

#include <algorithm>

#include "server/rtp/rtp_packet.hpp"

namespace fanlight {

namespace {

using Unit = std::span<const std::uint8_t>;
using Payload = std::vector<std::uint8_t>;

// Kinds of RTP payloads besides single units (RFC 6184, table 1).
constexpr std::uint8_t kStapA = 24;
constexpr std::uint8_t kFuA = 28;
constexpr std::uint8_t kImportance = 0x60;  // nal_ref_idc
constexpr std::size_t kStapHeaderBytes = 1;
constexpr std::size_t kStapSizeBytes = 2;
constexpr std::size_t kFuHeaderBytes = 2;

/// Where the next start code begins, from `from` on; the size of the stream if there is none.
std::size_t find_start_code(Unit stream, std::size_t from) {
  for (std::size_t at = from; at + 3 <= stream.size(); ++at) {
    if (stream[at] == 0 && stream[at + 1] == 0 && stream[at + 2] == 1) return at;
  }
  return stream.size();
}

void put_fragments(std::vector<Payload>& payloads, Unit unit, std::size_t most_bytes) {
  const std::uint8_t indicator = static_cast<std::uint8_t>((unit.front() & 0xe0) | kFuA);
  const std::uint8_t kind = unit.front() & 31;
  Unit rest = unit.subspan(1);  // the fragments' headers say what the unit's did
  const std::size_t room = most_bytes - kFuHeaderBytes;
  for (std::size_t left = (rest.size() + room - 1) / room; left > 0; --left) {
    const std::size_t bytes = (rest.size() + left - 1) / left;
    const bool first = rest.size() + 1 == unit.size();
    Payload& payload = payloads.emplace_back();
    payload.reserve(kFuHeaderBytes + bytes);
    payload.push_back(indicator);
    payload.push_back(static_cast<std::uint8_t>((first ? 0x80 : 0) | (left == 1 ? 0x40 : 0) | kind));
    payload.insert(payload.end(), rest.begin(), rest.begin() + static_cast<std::ptrdiff_t>(bytes));
    rest = rest.subspan(bytes);
  }
}

/// How many of the first units fit into one STAP-A.
std::size_t aggregable(std::span<const Unit> units, std::size_t most_bytes) {
  std::size_t bytes = kStapHeaderBytes;
  std::size_t count = 0;
  for (const Unit unit : units) {
    bytes += kStapSizeBytes + unit.size();
    if (bytes > most_bytes) break;
    ++count;
  }
  return count;
}

void put_aggregate(std::vector<Payload>& payloads, std::span<const Unit> units) {
  Payload& payload = payloads.emplace_back(1, kStapA);
  std::uint8_t importance = 0;
  for (const Unit unit : units) {
    importance = std::max<std::uint8_t>(importance, unit.front() & kImportance);
    put_u16(payload, static_cast<std::uint16_t>(unit.size()));
    payload.insert(payload.end(), unit.begin(), unit.end());
  }
  payload.front() |= importance;
}

}  // namespace

std::vector<Unit> nal_units(Unit stream) {
  std::vector<Unit> units;
  constexpr std::size_t kCodeBytes = 3;
  for (std::size_t code = find_start_code(stream, 0); code < stream.size();) {
    const std::size_t begin = code + kCodeBytes;
    code = find_start_code(stream, begin);
    Unit unit = stream.subspan(begin, code - begin);
    // A start code may have a zero byte more, and zero bytes may trail a unit; none ends with one.
    while (!unit.empty() && unit.back() == 0) unit = unit.first(unit.size() - 1);
    if (!unit.empty()) units.push_back(unit);
  }
  return units;
}

std::vector<Payload> h264_payloads(std::span<const Unit> units, std::size_t most_bytes) {
  std::vector<Payload> payloads;
  while (!units.empty()) {
    const std::size_t count = aggregable(units, most_bytes);
    if (count >= 2) {
      put_aggregate(payloads, units.first(count));
    } else if (units.front().size() <= most_bytes) {
      payloads.emplace_back(units.front().begin(), units.front().end());
    } else {
      put_fragments(payloads, units.front(), most_bytes);
    }
    units = units.subspan(std::max<std::size_t>(count, 1));
  }
  return payloads;
}

}  // namespace fanlight
