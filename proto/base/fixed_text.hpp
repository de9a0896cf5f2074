// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <string_view>

namespace fanlight {

/// A text in a field of fixed length, padded with zeros. Holds no memory elsewhere.
template <std::size_t kLength>
class FixedText {
 public:
  FixedText() = default;
  /// Longer texts are cut.
  FixedText(std::string_view text) {  // NOLINT(google-explicit-constructor): names are written as literals
    std::ranges::copy(text.substr(0, kLength), characters_.begin());
  }
  FixedText(const char* text) : FixedText(std::string_view(text)) {}  // NOLINT(google-explicit-constructor)
  explicit FixedText(std::span<const char, kLength> field) { std::ranges::copy(field, characters_.begin()); }

  /// Up to the first zero.
  std::string_view view() const {
    const auto end = std::ranges::find(characters_, '\0');
    return {characters_.data(), static_cast<std::size_t>(end - characters_.begin())};
  }
  const std::array<char, kLength>& field() const { return characters_; }
  bool empty() const { return characters_[0] == '\0'; }
  bool operator==(const FixedText& other) const { return view() == other.view(); }

 private:
  std::array<char, kLength> characters_{};
};

}  // namespace fanlight
