// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "proto/base/result.hpp"

namespace fanlight {

/// The hash that the first line of a log follows.
inline constexpr std::string_view kAuditBeginning =
    "0000000000000000000000000000000000000000000000000000000000000000";

/// Result of the entry that begins a file which continues the chain of another.
inline constexpr const char* kAuditContinues = "continues";
/// Result of the entry that says how many lines were lost before it.
inline constexpr const char* kAuditLost = "lost";
/// Of a file that is to take the name of the log, see AuditFile.
inline constexpr const char* kAuditNextSuffix = ".next";

/// A place in the chain: the number of a line, from 1 on, and its SHA-256.
struct AuditPosition {
  std::uint64_t line = 0;
  std::string hash = std::string(kAuditBeginning);
};

/// Checks lines one after another: each has the number and the hash that come next.
class AuditChain {
 public:
  /// What the first line may be.
  enum class Begin : std::uint8_t {
    kOfFile,    ///< line 1, or an entry that continues the chain of another file
    kAnywhere,  ///< any line: what is before it is not checked
  };
  explicit AuditChain(Begin begin) : begin_(begin) {}

  /// Takes the next line, without its line end. Returns false if it does not follow; then nothing changes.
  bool take(std::string_view text);

  /// The line that was taken last.
  const AuditPosition& position() const { return position_; }
  /// Of the lines taken: their number, the first, the hash that it follows, and the lines that are missing
  /// according to entries of the log itself.
  std::uint64_t lines() const { return lines_; }
  std::uint64_t first_line() const { return first_line_; }
  const std::string& first_follows() const { return first_follows_; }
  std::uint64_t lost() const { return lost_; }

 private:
  Begin begin_;
  AuditPosition position_;
  std::uint64_t lines_ = 0;
  std::uint64_t first_line_ = 0;
  std::string first_follows_;
  std::uint64_t lost_ = 0;
};

/// The number of a line of the log; 0 if the text is none.
std::uint64_t audit_line_number(std::string_view text);

/// The content of a log with an intact chain of hashes.
struct AuditSummary {
  std::uint64_t lines = 0;
  std::uint64_t first_line = 0;  ///< over 1: the log continues one that was not given
  std::string first_follows;     ///< the hash that the first line follows
  std::string newest_hash;       ///< empty for an empty file
  std::uint64_t lost = 0;        ///< lines that could not be written, as entries of the log say
};

/// Reads a whole log. Error, kBadInput: the first line whose hash does not match the line before it.
Result<AuditSummary> verify_audit_log(const std::filesystem::path& path);

/// The same for a log in several files, in any order: the files must follow each other.
Result<AuditSummary> verify_audit_logs(std::span<const std::filesystem::path> paths);

/// The error of a line that does not follow.
Error broken_audit_chain(const std::filesystem::path& path, std::uint64_t line);

}  // namespace fanlight
