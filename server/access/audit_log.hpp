// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "proto/base/result.hpp"
#include "server/access/digest.hpp"
#include "server/access/role.hpp"

namespace fanlight {

/// An append-only file with one line of JSON for each event: the time, the principal, the action and its
/// result. Each line holds the SHA-256 of the line before it, so that a changed, removed or inserted line is
/// detected. A truncated end is not detected: keep the newest hash elsewhere (the server logs it when it
/// ends). The file holds names of tokens and addresses, no secrets and no image data. One thread.
class AuditLog {
 public:
  struct Event {
    const char* what;           ///< name of the event: "login", "scene_change", ...
    std::uint64_t session = 0;  ///< 0: none
    std::string result;         ///< "done", or the reason of the failure
  };

  /// Keeps no log.
  AuditLog() = default;
  AuditLog(AuditLog&& other) noexcept;
  AuditLog& operator=(AuditLog&& other) noexcept;
  ~AuditLog();

  /// Opens the file to append to it. Creates it with access for its owner only if it does not exist. Errors:
  /// it cannot be written, or its chain of hashes is broken.
  static Result<AuditLog> open(const std::filesystem::path& path);

  /// Appends a line. If the disk is full, the line is lost and counted in lines_lost().
  void note(const Principal& who, const Event& event, const nlohmann::json& details);
  void note(const Principal& who, const Event& event);

  /// The same for events that any client can cause at any rate, above all refusals. Writes at most
  /// kRefusalsASecond lines in a second; the further ones of that second are only counted.
  void note_refusal(const Principal& who, const Event& event, const nlohmann::json& details);
  void note_refusal(const Principal& who, const Event& event);

  /// Call this once a second.
  void second_passed();

  std::uint64_t lines() const { return lines_; }
  std::uint64_t lines_lost() const { return lines_lost_; }
  const std::string& newest_hash() const { return newest_hash_; }

 private:
  static constexpr int kRefusalsASecond = 20;

  int file_ = -1;
  std::uint64_t lines_ = 0;
  std::uint64_t lines_lost_ = 0;
  std::uint64_t bytes_ = 0;  // size of the file
  std::string newest_hash_;
  int refusals_left_ = kRefusalsASecond;
  std::uint64_t refusals_unlisted_ = 0;
};

/// The content of a log with an intact chain of hashes.
struct AuditSummary {
  std::uint64_t lines = 0;
  std::string newest_hash;  ///< empty for an empty file
};

/// Reads a whole log. Error, kBadInput: the first line whose hash does not match the line before it.
Result<AuditSummary> verify_audit_log(const std::filesystem::path& path);

}  // namespace fanlight
