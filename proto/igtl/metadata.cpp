// SPDX-License-Identifier: Apache-2.0
#include "proto/igtl/metadata.hpp"

#include "proto/igtl/big_endian.hpp"

namespace fanlight::igtl {

namespace {
constexpr std::size_t kItemBytes = 8;
}

std::optional<Metadata> Metadata::parse(std::span<const std::uint8_t> index,
                                        std::span<const std::uint8_t> texts) {
  Metadata found;
  found.index_ = index;
  found.texts_ = texts;
  if (index.size() % kItemBytes != 0) return std::nullopt;
  found.items_ = static_cast<std::uint32_t>(index.size() / kItemBytes);
  std::uint64_t all = 0;
  for (std::uint32_t i = 0; i < found.items_; ++i) {
    const Lengths of = found.lengths(i);
    all += of.name + of.value;
  }
  if (all != texts.size()) return std::nullopt;
  return found;
}

Metadata::Lengths Metadata::lengths(std::uint32_t item) const {
  const auto at = index_.subspan(item * kItemBytes, kItemBytes);
  return {big_endian<std::uint16_t>(at), big_endian<std::uint32_t>(at.subspan(4))};
}

std::optional<std::string_view> Metadata::find(std::string_view name) const {
  std::size_t at = 0;
  for (std::uint32_t i = 0; i < items_; ++i) {
    const Lengths of = lengths(i);
    if (text(at, of.name) == name) return text(at + of.name, of.value);
    at += of.name + of.value;
  }
  return std::nullopt;
}

}  // namespace fanlight::igtl
