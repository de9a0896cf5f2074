// SPDX-License-Identifier: Apache-2.0
#include "proto/igtl/text_bodies.hpp"

#include <algorithm>

#include "proto/igtl/big_endian.hpp"

namespace fanlight::igtl {

namespace {

constexpr std::size_t kStatusHeader = 30;
constexpr std::size_t kStringHeader = 4;
constexpr std::size_t kCommandHeader = 138;
constexpr std::size_t kCommandName = 128;
// Of IANA's numbers of character sets.
constexpr std::uint16_t kAscii = 3;

template <std::size_t kLength>
FixedText<kLength> text_at(std::span<const std::uint8_t> bytes) {
  return FixedText<kLength>(
      std::span<const char, kLength>(reinterpret_cast<const char*>(bytes.data()), kLength));
}

/// Without the zero that C programs send behind a text.
std::string_view text_of(std::span<const std::uint8_t> bytes) {
  std::string_view text{reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  while (!text.empty() && text.back() == '\0') text.remove_suffix(1);
  return text;
}

template <typename Text>
void put(std::vector<std::uint8_t>& bytes, const Text& text) {
  bytes.insert(bytes.end(), text.begin(), text.end());
}

}  // namespace

std::optional<StatusBody> parse_status(std::span<const std::uint8_t> content) {
  if (content.size() < kStatusHeader) return std::nullopt;
  return StatusBody{.code = static_cast<StatusCode>(big_endian<std::uint16_t>(content)),
                    .sub_code = static_cast<std::int64_t>(big_endian<std::uint64_t>(content.subspan(2))),
                    .name = text_at<20>(content.subspan(10)),
                    .text = text_of(content.subspan(kStatusHeader))};
}

void put_status(std::vector<std::uint8_t>& bytes, const StatusBody& status) {
  put_big_endian(bytes, static_cast<std::uint16_t>(status.code));
  put_big_endian(bytes, static_cast<std::uint64_t>(status.sub_code));
  put(bytes, status.name.field());
  put(bytes, status.text);
  bytes.push_back(0);  // the library of OpenIGTLink reads up to it
}

std::optional<std::string_view> parse_string(std::span<const std::uint8_t> content) {
  if (content.size() < kStringHeader) return std::nullopt;
  const std::size_t length = big_endian<std::uint16_t>(content.subspan(2));
  if (content.size() != kStringHeader + length) return std::nullopt;
  return text_of(content.subspan(kStringHeader));
}

void put_string(std::vector<std::uint8_t>& bytes, std::string_view text) {
  text = text.substr(0, 65'535);
  put_big_endian(bytes, kAscii);
  put_big_endian(bytes, static_cast<std::uint16_t>(text.size()));
  put(bytes, text);
}

std::optional<CommandBody> parse_command(std::span<const std::uint8_t> content) {
  if (content.size() < kCommandHeader) return std::nullopt;
  const std::size_t length = big_endian<std::uint32_t>(content.subspan(4 + kCommandName + 2));
  if (content.size() != kCommandHeader + length) return std::nullopt;
  return CommandBody{.id = big_endian<std::uint32_t>(content),
                     .name = text_at<kCommandName>(content.subspan(4)),
                     .text = text_of(content.subspan(kCommandHeader))};
}

void put_command(std::vector<std::uint8_t>& bytes, const CommandBody& command) {
  put_big_endian(bytes, command.id);
  put(bytes, command.name.field());
  put_big_endian(bytes, kAscii);
  put_big_endian(bytes, static_cast<std::uint32_t>(command.text.size()));
  put(bytes, command.text);
}

void put_capability(std::vector<std::uint8_t>& bytes, std::span<const TypeName> types) {
  for (const TypeName& type : types) put(bytes, type.field());
}

std::vector<TypeName> parse_capability(std::span<const std::uint8_t> content) {
  std::vector<TypeName> types;
  if (content.size() % kTypeLength != 0) return types;
  for (std::size_t at = 0; at < content.size(); at += kTypeLength)
    types.push_back(text_at<kTypeLength>(content.subspan(at)));
  return types;
}

}  // namespace fanlight::igtl
