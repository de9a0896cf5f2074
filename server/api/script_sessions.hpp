// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <list>
#include <string>
#include <string_view>

#include "proto/base/result.hpp"
#include "proto/base/thread_owner.hpp"
#include "server/access/authenticator.hpp"
#include "server/access/control_lease.hpp"
#include "server/command/command_executor.hpp"
#include "server/command/session_audit.hpp"
#include "server/stream/session_registry.hpp"

namespace fanlight {

/// A script that has asked for control by POST /api/control. HTTP requests have no session, so it is known by
/// a key, which it shows in a header.
class ScriptSession {
 public:
  ScriptSession(AuditLog& log, SessionIdentity identity, std::string key, std::int64_t now_ns)
      : identity_(std::move(identity)), audit_(log, identity_), key_(std::move(key)), heard_ns_(now_ns) {}
  ScriptSession(const ScriptSession&) = delete;
  ScriptSession& operator=(const ScriptSession&) = delete;

  Requester requester() { return {.identity = identity_, .audit = audit_}; }
  const std::string& key() const { return key_; }
  std::uint64_t id() const { return identity_.id; }

 private:
  friend class ScriptSessions;
  SessionIdentity identity_;
  SessionAudit audit_;
  std::string key_;
  std::int64_t heard_ns_;
};

/// The scripts that are in control, or wait for it. One that shows no key for as long as control lapses after
/// is forgotten, and so is one whose token was revoked. Server thread only.
class ScriptSessions {
 public:
  static constexpr std::size_t kMost = 16;

  /// All must outlive this object.
  struct Dependencies {
    SessionRegistry& sessions;  ///< gives them numbers
    CommandExecutor& commands;
    ControlLease& control;
    const Authenticator& access;
    AuditLog& audit;
  };
  explicit ScriptSessions(const Dependencies& dependencies) : dependencies_(dependencies) {}

  /// `name`: as the others see it; empty: the principal's. Errors: kUnavailable: there are kMost;
  /// kInvalidArgument: the name.
  Result<ScriptSession*> open(const Principal& principal, const std::string& name, std::int64_t now_ns);

  /// The session of a key, which must be of this principal. Renews it, and its control. Null: there is none.
  ScriptSession* find(std::string_view key, const Principal& principal, std::int64_t now_ns);

  /// Ends it, and its control.
  void close(ScriptSession& session);

  void close_all();

  /// Call it once a second.
  void second_passed(std::int64_t now_ns);

 private:
  using Sessions = std::list<ScriptSession>;
  Sessions::iterator close(Sessions::iterator session);

  Dependencies dependencies_;
  Sessions sessions_;
  [[no_unique_address]] ThreadOwner thread_owner_;
};

}  // namespace fanlight
