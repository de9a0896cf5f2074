// SPDX-License-Identifier: Apache-2.0
#include "server/rtp/user_data_sei.hpp"

#include <algorithm>

namespace fanlight {

namespace {

constexpr std::uint8_t kSeiUnit = 6;
constexpr std::uint8_t kUserDataUnregistered = 5;
constexpr std::uint8_t kStopBit = 0x80;

/// A number as SEI messages have it: 255 for each whole 255, then the rest.
void put_number(std::vector<std::uint8_t>& bytes, std::size_t value) {
  for (; value >= 255; value -= 255) bytes.push_back(255);
  bytes.push_back(static_cast<std::uint8_t>(value));
}

/// Appends the payload of a unit: after two zero bytes, 3 comes before a byte of 3 or less (H.264, 7.4.1).
void put_escaped(std::vector<std::uint8_t>& unit, std::span<const std::uint8_t> payload) {
  int zeros = 0;
  for (const std::uint8_t byte : payload) {
    if (zeros == 2 && byte <= 3) {
      unit.push_back(3);
      zeros = 0;
    }
    unit.push_back(byte);
    zeros = byte == 0 ? zeros + 1 : 0;
  }
}

std::vector<std::uint8_t> without_escapes(std::span<const std::uint8_t> payload) {
  std::vector<std::uint8_t> plain;
  plain.reserve(payload.size());
  int zeros = 0;
  for (const std::uint8_t byte : payload) {
    if (zeros == 2 && byte == 3) {
      zeros = 0;
      continue;
    }
    plain.push_back(byte);
    zeros = byte == 0 ? zeros + 1 : 0;
  }
  return plain;
}

std::optional<std::size_t> take_number(std::span<const std::uint8_t>& bytes) {
  std::size_t value = 0;
  for (;;) {
    if (bytes.empty()) return std::nullopt;
    const std::uint8_t byte = bytes.front();
    bytes = bytes.subspan(1);
    value += byte;
    if (byte != 255) return value;
  }
}

}  // namespace

std::vector<std::uint8_t> user_data_sei(std::string_view data) {
  std::vector<std::uint8_t> payload = {kUserDataUnregistered};
  payload.reserve(data.size() + data.size() / 255 + 32);
  put_number(payload, kPictureDataUuid.size() + data.size());
  payload.insert(payload.end(), kPictureDataUuid.begin(), kPictureDataUuid.end());
  payload.insert(payload.end(), data.begin(), data.end());
  payload.push_back(kStopBit);
  std::vector<std::uint8_t> unit = {kSeiUnit};
  unit.reserve(payload.size() + payload.size() / 2);
  put_escaped(unit, payload);
  return unit;
}

std::optional<std::string> read_user_data_sei(std::span<const std::uint8_t> unit) {
  if (unit.empty() || (unit.front() & 31) != kSeiUnit) return std::nullopt;
  const std::vector<std::uint8_t> plain = without_escapes(unit.subspan(1));
  std::span<const std::uint8_t> rest = plain;
  const auto kind = take_number(rest);
  const auto bytes = take_number(rest);
  if (!kind || *kind != kUserDataUnregistered || !bytes || *bytes > rest.size()) return std::nullopt;
  if (*bytes < kPictureDataUuid.size() ||
      !std::ranges::equal(rest.first(kPictureDataUuid.size()), kPictureDataUuid))
    return std::nullopt;
  const auto data = rest.first(*bytes).subspan(kPictureDataUuid.size());
  return std::string(data.begin(), data.end());
}

}  // namespace fanlight
