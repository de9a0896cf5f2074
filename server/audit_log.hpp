#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "proto/result.hpp"
#include "server/digest.hpp"
#include "server/role.hpp"

namespace fanlight {

/// Who did what, when, with what result: a line of JSON each, only ever appended, each with the SHA-256 over
/// the line before it, so that a line that was changed, taken out or put in between shows. What it cannot
/// show is that its end was cut off: keep the newest hash elsewhere (the server logs it when it ends). Holds
/// names of tokens and addresses, no secrets and nothing of what is scanned. One thread.
class AuditLog {
 public:
  struct Event {
    const char* what;           ///< "login", "scene_change", ...
    std::uint64_t session = 0;  ///< 0: none
    std::string result;         ///< "done", or why not
  };

  /// Keeps no log.
  AuditLog() = default;
  AuditLog(AuditLog&& other) noexcept;
  AuditLog& operator=(AuditLog&& other) noexcept;
  ~AuditLog();

  /// Goes on behind the last line of the file, which is made, for its owner alone, where there is none.
  /// Errors: it cannot be written, or does not hold together as it is.
  static Result<AuditLog> open(const std::filesystem::path& path);

  /// Appends a line. Where the disk has no room the line is lost, and counted.
  void note(const Visitor& who, const Event& event, const nlohmann::json& details);
  void note(const Visitor& who, const Event& event);

  /// The same for what anybody may cause as often as they like, refusals above all: so many a second, and of
  /// the others their number.
  void note_refusal(const Visitor& who, const Event& event, const nlohmann::json& details);
  void note_refusal(const Visitor& who, const Event& event);

  /// A second has passed.
  void second_passed();

  std::uint64_t lines() const { return lines_; }
  std::uint64_t lines_lost() const { return lines_lost_; }
  const std::string& newest_hash() const { return newest_hash_; }

 private:
  static constexpr int kRefusalsASecond = 20;

  int file_ = -1;
  std::uint64_t lines_ = 0;
  std::uint64_t lines_lost_ = 0;
  std::uint64_t bytes_ = 0;  // of the file
  std::string newest_hash_;
  int refusals_left_ = kRefusalsASecond;
  std::uint64_t refusals_unlisted_ = 0;
};

/// What a file holds that holds together.
struct AuditSummary {
  std::uint64_t lines = 0;
  std::string newest_hash;  ///< empty for an empty file
};

/// Reads all of a log. Error: kBadInput with the first line that does not follow from the one before it.
Result<AuditSummary> verify_audit_log(const std::filesystem::path& path);

}  // namespace fanlight
