// SPDX-License-Identifier: Apache-2.0
#include "proto/base/toml_excess.hpp"

#include <fmt/format.h>

#include <cstddef>

namespace fanlight {

namespace {

// No file of ours needs more than 3.
constexpr std::size_t kMostParts = 16;
constexpr std::size_t kMostOpen = 16;

/// Offset behind the string or comment that begins at `at`; `at` itself where neither does.
std::size_t behind_text(std::string_view text, std::size_t at) {
  if (text[at] == '#') return text.find('\n', at);
  if (text[at] != '"' && text[at] != '\'') return at;
  const bool escapes = text[at] == '"';
  const std::string_view three = text.substr(at, 3);
  const bool is_long = three == "\"\"\"" || three == "'''";
  const std::string_view end = is_long ? three : text.substr(at, 1);
  for (std::size_t next = at + end.size(); next < text.size(); ++next) {
    if (escapes && text[next] == '\\') {
      ++next;
    } else if (text.substr(next, end.size()) == end) {
      next += end.size();
      // Up to two quotes before the three that end a long string belong to it.
      for (int more = 0; is_long && more < 2 && next < text.size() && text[next] == text[at]; ++more) ++next;
      return next;
    } else if (!is_long && text[next] == '\n') {
      return next;  // no TOML
    }
  }
  return text.size();
}

}  // namespace

std::string toml_excess(std::string_view text) {
  std::size_t open = 0;
  std::size_t dots = 0;  // since the last thing that ends a key or a number
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t next = behind_text(text, at);
    if (next != at) {
      at = next;  // npos: to the end
      continue;
    }
    const char letter = text[at++];
    if (letter == '[' || letter == '{') ++open;
    if ((letter == ']' || letter == '}') && open > 0) --open;
    if (letter == '.') ++dots;
    if (letter == ',' || letter == '=' || letter == '\n') dots = 0;
    if (open > kMostOpen) return fmt::format("more than {} brackets are open at once", kMostOpen);
    if (dots >= kMostParts) return fmt::format("a key has more than {} parts", kMostParts);
  }
  return {};
}

}  // namespace fanlight
