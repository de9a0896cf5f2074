// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "proto/fanlight.pb.h"
#include "server/access/audit_log.hpp"
#include "server/access/session_identity.hpp"

namespace fanlight {

/// Writes the audit lines of one client. Precondition of all methods: it is authenticated. Server thread
/// only.
class SessionAudit {
 public:
  /// Both must outlive this object.
  SessionAudit(AuditLog& log, const SessionIdentity& session) : log_(log), session_(session) {}

  /// See AuditLog::refuses_acts().
  bool refuses_acts() const { return log_.refuses_acts(); }

  /// Writes a line, within the budget of this session: see AuditBudget.
  void note(const char* what, const std::string& result);
  void note(const char* what, const std::string& result, const nlohmann::json& details);

  /// The scene was changed. A second's changes of a session make one line: see flush_changes(). Without a
  /// session each makes one, within the budget.
  void add_change(const v1::Scene& change);

  /// Called once a second and at the end: writes a line about the changes since the last call, if any.
  void flush_changes();

 private:
  AuditLog& log_;
  const SessionIdentity& session_;
  v1::Scene changes_;
  std::uint64_t change_count_ = 0;
};

}  // namespace fanlight
