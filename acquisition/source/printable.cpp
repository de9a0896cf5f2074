// SPDX-License-Identifier: Apache-2.0
#include "acquisition/source/printable.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "proto/base/printable.hpp"

namespace fanlight {

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r";
  const auto first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) + 1 - first);
}

std::string in_quotes(std::string_view text) {
  constexpr std::size_t kMost = 40;
  std::string shown(text.substr(0, kMost));
  std::ranges::replace_if(
      shown, [](char c) { return c < ' ' || c > '~'; }, '?');
  if (text.size() > kMost) shown += "...";
  return '"' + shown + '"';
}

std::string shown(const std::filesystem::path& path) {
  return printable(path.string());
}

Error bad_file(const std::filesystem::path& path, std::string_view wrong, std::string_view expected,
               ErrorCode code) {
  return {code, fmt::format("{}: {}, expected {}", shown(path), wrong, expected)};
}

}  // namespace fanlight
