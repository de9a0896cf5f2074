// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstdio>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "acquisition/source/printable.hpp"
#include "proto/base/result.hpp"

namespace fanlight {

/// A file that is being read. It is not trusted.
struct NamedFile {
  std::string name;           ///< for error messages
  std::FILE* file = nullptr;  ///< at its first byte
  std::uint64_t bytes = 0;

  /// "NAME: WRONG, expected EXPECTED".
  Error bad(std::string_view wrong, std::string_view expected, ErrorCode code = ErrorCode::kBadInput) const;
};

/// A field of a header.
struct HeaderField {
  std::string_view key;
  std::string_view value;

  /// "KEY" is "VALUE", expected EXPECTED.
  Error refused(const NamedFile& file, std::string_view expected,
                ErrorCode code = ErrorCode::kBadInput) const;
};

/// Reads the lines of a header of text. One thread.
class HeaderLines {
 public:
  explicit HeaderLines(const NamedFile& from) : from_(from) {}

  /// The next line without its end; valid until the next call. nullopt: the file has ended. kBadInput: the
  /// line is no text, or too long.
  Result<std::optional<std::string_view>> next();

  std::uint64_t bytes() const { return bytes_; }    ///< read so far
  std::uint64_t number() const { return number_; }  ///< of the last line, from 1

 private:
  const NamedFile& from_;
  std::string line_;
  std::uint64_t bytes_ = 0;
  std::uint64_t number_ = 0;
};

/// Numbers at the front of `text`, separated by blanks; returns the text behind them, or nullopt.
template <typename T>
std::optional<std::string_view> take_numbers(std::string_view text, std::span<T> numbers) {
  for (T& each : numbers) {
    const auto word = text.substr(0, text.find(' '));
    const auto number = number_in<T>(word);
    if (!number) return std::nullopt;
    each = *number;
    text = trimmed(text.substr(word.size()));
  }
  return text;
}

}  // namespace fanlight
