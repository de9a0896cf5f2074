// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "proto/base/result.hpp"
#include "proto/base/thread_owner.hpp"
#include "server/access/audit_chain.hpp"
#include "server/access/audit_entry.hpp"
#include "server/access/digest.hpp"
#include "server/access/role.hpp"

namespace fanlight {

class AuditBudget;
class AuditWriter;

/// An append-only file with one line of JSON for each event: the time, the principal, the action and its
/// result. Each line holds the SHA-256 of the line before it, so that a changed, removed or inserted line is
/// detected. A truncated end is not detected: keep the newest hash elsewhere (the server logs it when it
/// ends). The file holds names of tokens and addresses, no secrets and no image data.
///
/// note() never waits for the disk: a thread of its own writes. Lines that were lost, by a full disk, a full
/// pipe or a full queue, and events beyond a client's budget are counted in an entry of the log. One thread.
class AuditLog {
 public:
  using Event = AuditEvent;

  /// Keeps no log.
  AuditLog();
  AuditLog(AuditLog&& other) noexcept;
  AuditLog& operator=(AuditLog&& other) noexcept;
  ~AuditLog();

  /// Opens the file to append to it: see AuditFile::open(), also for `rotate_bytes` and the errors.
  static Result<AuditLog> open(const std::filesystem::path& path, std::uint64_t rotate_bytes = 0);

  /// From now on an act whose line cannot be written is to be refused.
  void require() { is_required_ = true; }
  /// Whether an act is to be refused now, as require() demands.
  bool refuses_acts() const;

  /// Appends a line, unless the client has used up its budget for such events: see AuditBudget.
  void note(const Principal& who, const Event& event, const nlohmann::json& details);
  void note(const Principal& who, const Event& event);

  /// Call this once a second: appends the lines about what was folded.
  void second_passed();

  /// Continues the log in a new file if the present one was moved or removed, soon after this call.
  void reopen();

  /// Blocks until all lines are written or lost, at most 10 s. Returns whether they are. For tests.
  bool wait_until_written();

  /// Writes what is left, for at most 2 s, and closes the log. Returns false if it took longer.
  bool close();

  /// The last line that was written: its number and its hash. Line 0: none.
  AuditPosition newest() const;
  std::uint64_t lines_lost() const;

  /// Sentences for the log of the server since the last call; empty: none.
  std::string take_notice();

 private:
  void append(const Principal& who, const Event& event, const nlohmann::json& details);
  /// `all`: also what is folded for longer than a second.
  void append_folded(bool all);

  std::unique_ptr<AuditWriter> writer_;  // null: no log
  std::unique_ptr<AuditBudget> budget_;
  bool is_required_ = false;
  [[no_unique_address]] ThreadOwner thread_owner_;
};

}  // namespace fanlight
