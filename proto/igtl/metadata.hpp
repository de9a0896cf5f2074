// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

namespace fanlight::igtl {

/// Names and values behind the content of a message with an extended header (version 2 and 3).
class Metadata {
 public:
  Metadata() = default;
  /// `index`: for each item two bytes with the length of its name, two with the encoding of its value, four
  /// with the value's length. `texts`: name and value of each item. nullopt: they do not fit together.
  static std::optional<Metadata> parse(std::span<const std::uint8_t> index,
                                       std::span<const std::uint8_t> texts);

  /// The value of the first item of this name, as it came.
  std::optional<std::string_view> find(std::string_view name) const;

  std::uint32_t size() const { return items_; }
  /// Calls take(name, value) for each item, in order.
  template <typename Take>
  void for_each(Take take) const {
    std::size_t at = 0;
    for (std::uint32_t i = 0; i < items_; ++i) {
      const Lengths of = lengths(i);
      take(text(at, of.name), text(at + of.name, of.value));
      at += of.name + of.value;
    }
  }

 private:
  struct Lengths {
    std::size_t name = 0;
    std::size_t value = 0;
  };
  Lengths lengths(std::uint32_t item) const;
  std::string_view text(std::size_t at, std::size_t length) const {
    return {reinterpret_cast<const char*>(texts_.data()) + at, length};
  }

  std::span<const std::uint8_t> index_;
  std::span<const std::uint8_t> texts_;
  std::uint32_t items_ = 0;
};

/// Items to write: names of up to 65535 bytes.
using MetadataItems = std::span<const std::pair<std::string_view, std::string_view>>;

}  // namespace fanlight::igtl
