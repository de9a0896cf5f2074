// SPDX-License-Identifier: Apache-2.0
#include "proto/igtl/message_writer.hpp"

#include <algorithm>

#include "proto/base/crc64.hpp"
#include "proto/igtl/big_endian.hpp"

namespace fanlight::igtl {

namespace {

// Of IANA's numbers of character sets: ASCII, which PLUS writes.
constexpr std::uint16_t kEncoding = 3;
constexpr std::size_t kMostItems = 8191;  // the index has a length of 16 bits
constexpr std::uint16_t kExtendedLength = 12;

}  // namespace

std::vector<std::uint8_t>& MessageWriter::begin(const Envelope& envelope) {
  head_ = {.version = static_cast<std::uint16_t>(envelope.version),
           .type = envelope.type,
           .device = envelope.device,
           .timestamp = envelope.timestamp};
  bytes_.assign(kHeadBytes, 0);
  index_.clear();
  texts_.clear();
  if (envelope.version == HeadVersion::kOne) return bytes_;
  const auto items = envelope.metadata.first(std::min(envelope.metadata.size(), kMostItems));
  put_big_endian(index_, static_cast<std::uint16_t>(items.size()));
  for (const auto& [name, value] : items) {
    put_big_endian(index_, static_cast<std::uint16_t>(name.size()));
    put_big_endian(index_, kEncoding);
    put_big_endian(index_, static_cast<std::uint32_t>(value.size()));
    texts_.insert(texts_.end(), name.begin(), name.end());
    texts_.insert(texts_.end(), value.begin(), value.end());
  }
  put_big_endian(bytes_, kExtendedLength);
  put_big_endian(bytes_, static_cast<std::uint16_t>(index_.size()));
  put_big_endian(bytes_, static_cast<std::uint32_t>(texts_.size()));
  put_big_endian(bytes_, envelope.message_id);
  return bytes_;
}

std::span<const std::uint8_t> MessageWriter::finish() {
  bytes_.insert(bytes_.end(), index_.begin(), index_.end());
  bytes_.insert(bytes_.end(), texts_.begin(), texts_.end());
  const auto body = std::span(bytes_).subspan(kHeadBytes);
  head_.body_bytes = body.size();
  head_.crc = crc64(body);
  write_head(std::span(bytes_).first<kHeadBytes>(), head_);
  return bytes_;
}

}  // namespace fanlight::igtl
