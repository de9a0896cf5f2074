// SPDX-License-Identifier: Apache-2.0
#include "proto/igtl/message_head.hpp"

#include <openigtlink/igtl_header.h>

#include <algorithm>
#include <cstring>
#include <utility>

namespace fanlight::igtl {

namespace {

static_assert(sizeof(igtl_header) == kHeadBytes);
constexpr std::uint16_t kNewestVersion = 3;

/// Texts of another program are shown in logs.
template <std::size_t kLength>
FixedText<kLength> text_of(const char (&field)[kLength]) {
  return FixedText<kLength>(std::span<const char, kLength>(field));
}

bool is_name(std::string_view text) {
  return std::ranges::all_of(text, [](char each) { return each > ' ' && each <= '~'; });
}

}  // namespace

std::optional<MessageHead> parse_head(std::span<const std::uint8_t, kHeadBytes> bytes) {
  igtl_header packed;
  std::memcpy(&packed, bytes.data(), kHeadBytes);
  igtl_header_convert_byte_order(&packed);
  const MessageHead head{.version = packed.version,
                         .type = text_of(packed.name),
                         .device = text_of(packed.device_name),
                         .timestamp = packed.timestamp,
                         .body_bytes = packed.body_size,
                         .crc = packed.crc};
  const bool known = head.version >= 1 && head.version <= kNewestVersion;
  if (!known || head.type.empty() || !is_name(head.type.view())) return std::nullopt;
  return head;
}

void write_head(std::span<std::uint8_t, kHeadBytes> bytes, const MessageHead& head) {
  igtl_header packed{.version = head.version,
                     .name = {},
                     .device_name = {},
                     .timestamp = head.timestamp,
                     .body_size = head.body_bytes,
                     .crc = head.crc};
  std::ranges::copy(head.type.field(), packed.name);
  std::ranges::copy(head.device.field(), packed.device_name);
  igtl_header_convert_byte_order(&packed);
  std::memcpy(bytes.data(), &packed, kHeadBytes);
}

QueryType query_of(std::string_view type) {
  constexpr std::pair<std::string_view, Query> kPrefixes[] = {
      {"GET_", Query::kGet}, {"STT_", Query::kStart}, {"STP_", Query::kStop}, {"RTS_", Query::kReply}};
  for (const auto& [prefix, query] : kPrefixes)
    if (type.starts_with(prefix)) return {query, type.substr(prefix.size())};
  return {Query::kNone, type};
}

}  // namespace fanlight::igtl
