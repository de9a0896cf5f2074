// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

namespace fanlight {

/// A wish as scripts write it: "pause", or "step=-2".
struct WishText {
  std::string_view word;
  std::string_view argument;
  bool has_argument = false;

  explicit WishText(std::string_view text)
      : word(text.substr(0, text.find('='))), has_argument(word.size() < text.size()) {
    if (has_argument) argument = text.substr(word.size() + 1);
  }

  /// The argument as a finite number; absent where it is none.
  std::optional<double> number() const {
    double value = 0;
    const auto [end, failure] = std::from_chars(argument.data(), argument.data() + argument.size(), value);
    const bool whole = failure == std::errc() && end == argument.data() + argument.size();
    return whole && std::isfinite(value) ? std::optional(value) : std::nullopt;
  }
};

}  // namespace fanlight
