// SPDX-License-Identifier: Apache-2.0
#include "proto/base/printable.hpp"

#include <algorithm>
#include <array>

namespace fanlight {

namespace {

struct Character {
  char32_t code;
  std::size_t bytes;
};

constexpr char32_t kNoCharacter = 0xFFFFFFFF;

/// The first character; kNoCharacter and one byte where the text is no UTF-8 (RFC 3629). Precondition: the
/// text is not empty.
Character first_character(std::string_view text) {
  constexpr std::array<char32_t, 5> kLeast = {0, 0, 0x80, 0x800, 0x10000};  // by the number of bytes
  const auto byte = [text](std::size_t at) { return static_cast<unsigned char>(text[at]); };
  const unsigned char lead = byte(0);
  if (lead < 0x80) return {.code = lead, .bytes = 1};
  const std::size_t bytes = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  constexpr Character kWrong{.code = kNoCharacter, .bytes = 1};
  if (lead < 0xC2 || lead > 0xF4 || text.size() < bytes) return kWrong;
  char32_t code = lead & (0x7FU >> bytes);
  for (std::size_t at = 1; at < bytes; ++at) {
    if ((byte(at) & 0xC0) != 0x80) return kWrong;
    code = code << 6 | (byte(at) & 0x3FU);
  }
  const bool surrogate = code >= 0xD800 && code <= 0xDFFF;
  if (code < kLeast[bytes] || code > 0x10FFFF || surrogate) return kWrong;
  return {.code = code, .bytes = bytes};
}

struct Range {
  char32_t first;
  char32_t last;
};

// The joiners 200C and 200D are not among them: Persian, Indian scripts and emoji are written with them.
constexpr auto kNotShown = std::to_array<Range>({
    {0x0000, 0x001F},    // C0 controls
    {0x007F, 0x009F},    // DEL and C1 controls
    {0x00AD, 0x00AD},    // soft hyphen
    {0x061C, 0x061C},    // Arabic letter mark: direction
    {0x180E, 0x180E},    // Mongolian vowel separator: invisible
    {0x200B, 0x200B},    // zero width space
    {0x200E, 0x200F},    // marks of direction
    {0x2028, 0x202E},    // separators of lines and paragraphs; embedded and overriding direction
    {0x2060, 0x206F},    // invisible operators; isolated direction
    {0xFEFF, 0xFEFF},    // byte order mark
    {0xFFF9, 0xFFFB},    // interlinear annotation
    {0xE0000, 0xE0FFF},  // tags
});

bool is_shown(char32_t code) {
  if (code == kNoCharacter || (code & 0xFFFE) == 0xFFFE) return false;
  return std::ranges::none_of(
      kNotShown, [code](const Range& range) { return code >= range.first && code <= range.last; });
}

}  // namespace

bool is_printable(std::string_view text) {
  while (!text.empty()) {
    const Character next = first_character(text);
    if (!is_shown(next.code)) return false;
    text.remove_prefix(next.bytes);
  }
  return true;
}

std::string printable(std::string_view text) {
  std::string shown;
  shown.reserve(text.size());
  while (!text.empty()) {
    const Character next = first_character(text);
    if (is_shown(next.code)) {
      shown += text.substr(0, next.bytes);
    } else {
      shown += '?';
    }
    text.remove_prefix(next.bytes);
  }
  return shown;
}

}  // namespace fanlight
