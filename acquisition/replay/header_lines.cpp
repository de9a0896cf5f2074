// SPDX-License-Identifier: Apache-2.0
#include "acquisition/replay/header_lines.hpp"

#include <fmt/format.h>

namespace fanlight {

namespace {

constexpr std::size_t kLongestLine = 65'536;

}  // namespace

Error NamedFile::bad(std::string_view wrong, std::string_view expected, ErrorCode code) const {
  return {code, fmt::format("{}: {}, expected {}", name, wrong, expected)};
}

Error HeaderField::refused(const NamedFile& file, std::string_view expected, ErrorCode code) const {
  return file.bad(fmt::format("{} is {}", in_quotes(key), in_quotes(value)), expected, code);
}

Result<std::optional<std::string_view>> HeaderLines::next() {
  ++number_;
  line_.clear();
  for (;;) {
    const int c = std::getc(from_.file);
    if (c == EOF) return std::optional<std::string_view>();
    ++bytes_;
    if (c == '\n') break;
    const bool control = c < ' ' && c != '\t' && c != '\r';
    if (control || c == 0x7F)
      return from_.bad(fmt::format("line {} of the header holds byte {:#04x}", number_, c), "text");
    if (line_.size() == kLongestLine) {
      return from_.bad(fmt::format("line {} of the header is longer than {} bytes", number_, kLongestLine),
                       "shorter lines");
    }
    line_.push_back(static_cast<char>(c));
  }
  return std::optional<std::string_view>(line_);
}

}  // namespace fanlight
