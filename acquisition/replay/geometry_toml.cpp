// SPDX-License-Identifier: Apache-2.0
#include "acquisition/replay/geometry_toml.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <fstream>
#include <sstream>
#include <string>

#include "acquisition/source/printable.hpp"
#include "proto/base/toml_place.hpp"

namespace fanlight {

namespace {

Error bad(const std::filesystem::path& path, std::string_view wrong, std::string_view expected) {
  return {ErrorCode::kBadInput, fmt::format("{}: {}, expected {}", shown(path), wrong, expected)};
}

}  // namespace

Result<toml::value> parse_geometry_toml(const std::filesystem::path& path) {
  constexpr std::string_view kExpected = "lines such as motor_radius_mm = 28.0";
  // Far above the size of any geometry. The parser recurses into each bracket and each dot of a key without a
  // limit: 16 000 dots overflow its stack.
  constexpr std::size_t kMostBytes = 65'536;
  constexpr std::ptrdiff_t kMostBrackets = 16;
  constexpr std::ptrdiff_t kMostDotsInKeys = 64;
  std::string text(kMostBytes + 1, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (text.size() > kMostBytes)
    return bad(path, fmt::format("the file is longer than {} bytes", kMostBytes), kExpected);
  const auto brackets = std::ranges::count_if(text, [](char c) { return c == '[' || c == '{'; });
  if (brackets > kMostBrackets) return bad(path, "the file is full of brackets", kExpected);
  // Of one key: lists of numbers have commas between their dots.
  std::ptrdiff_t in_a_row = 0;
  std::ptrdiff_t most_in_a_row = 0;
  for (const char c : text) {
    if (c == '.') most_in_a_row = std::max(most_in_a_row, ++in_a_row);
    if (c == ',' || c == '=' || c == '\n') in_a_row = 0;
  }
  if (most_in_a_row > kMostDotsInKeys) return bad(path, "the file is full of dots", kExpected);
  try {
    std::istringstream stream(text);
    return toml::parse(stream, shown(path));
  } catch (const toml::syntax_error& failure) {
    return bad(path, fmt::format("line {} is not TOML", toml_error_line(failure)), kExpected);
  } catch (const std::exception&) {
    return bad(path, "the file is not TOML", kExpected);
  }
}

}  // namespace fanlight
