// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <charconv>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

#include "proto/base/result.hpp"

namespace fanlight {

/// The whole of `text` as a number; nullopt where it is none, is out of T's range, or is not finite.
template <typename T>
std::optional<T> number_in(std::string_view text) {
  T number{};
  const char* const end = text.data() + text.size();
  const auto [stopped, failure] = std::from_chars(text.data(), end, number);
  if (failure != std::errc{} || stopped != end) return std::nullopt;
  if constexpr (std::is_floating_point_v<T>) {
    if (!std::isfinite(number)) return std::nullopt;
  }
  return number;
}

/// `text` without leading and trailing blanks.
std::string_view trimmed(std::string_view text);

/// `text` from an untrusted file in quotes, for an error message: cut to 40 characters, everything but
/// printable ASCII replaced by '?'.
std::string in_quotes(std::string_view text);

/// A path for an error message: what is not printable() is replaced by '?'.
std::string shown(const std::filesystem::path& path);

/// "PATH: WRONG, expected EXPECTED".
Error bad_file(const std::filesystem::path& path, std::string_view wrong, std::string_view expected,
               ErrorCode code = ErrorCode::kBadInput);

}  // namespace fanlight
