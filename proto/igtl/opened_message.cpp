// SPDX-License-Identifier: Apache-2.0
#include "proto/igtl/opened_message.hpp"

#include "proto/base/crc64.hpp"
#include "proto/igtl/big_endian.hpp"

namespace fanlight::igtl {

namespace {

constexpr OpenedMessage kMalformed{.state = OpenedMessage::State::kMalformed};
constexpr std::size_t kExtendedBytes = 12;
constexpr std::size_t kCountBytes = 2;

}  // namespace

OpenedMessage open_message(const MessageHead& head, std::span<const std::uint8_t> body) {
  if (head.body_bytes != body.size() || crc64(body) != head.crc)
    return {.state = OpenedMessage::State::kDamaged};
  // A query without a body has none in any version.
  if (head.version < 2 || body.empty()) return {.content = body};
  if (body.size() < kExtendedBytes) return kMalformed;
  const std::size_t extended = big_endian<std::uint16_t>(body);
  const std::size_t index_bytes = big_endian<std::uint16_t>(body.subspan(2));
  const std::size_t text_bytes = big_endian<std::uint32_t>(body.subspan(4));
  OpenedMessage opened{.message_id = big_endian<std::uint32_t>(body.subspan(8))};
  if (extended < kExtendedBytes || extended + index_bytes + text_bytes > body.size()) return kMalformed;
  opened.content = body.subspan(extended, body.size() - extended - index_bytes - text_bytes);
  if (index_bytes == 0) return text_bytes == 0 ? opened : kMalformed;
  if (index_bytes < kCountBytes) return kMalformed;
  const auto index = body.subspan(extended + opened.content.size(), index_bytes);
  const auto items = index.subspan(kCountBytes);
  if (items.size() != std::size_t{8} * big_endian<std::uint16_t>(index)) return kMalformed;
  const auto metadata = Metadata::parse(items, body.last(text_bytes));
  if (!metadata) return kMalformed;
  opened.metadata = *metadata;
  return opened;
}

}  // namespace fanlight::igtl
