// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "server/access/role.hpp"
#include "server/command/command.hpp"
#include "server/state/server_counters.hpp"

namespace fanlight {

/// What a command requires of the control lease. A client without a session never holds it.
enum class ControlRule : std::uint8_t {
  kNone,      ///< it does not matter who is in control
  kFree,      ///< refused while another session is in control
  kAcquires,  ///< the same; the session is in control afterwards
};

/// Who may give a command, and what is counted.
struct CommandRule {
  const char* name;          ///< in the audit log
  Role least_role;           ///< checked in CommandExecutor::permission(), for all protocols
  const char* role_refusal;  ///< the sentence for a lesser role
  bool needs_session;        ///< refused to scripts and OpenIGTLink clients
  ControlRule control;       ///< see ControlLease
  Counter ServerCounters::*refusals;
  Counter ServerCounters::*done;  ///< null: not counted
};

/// The row of the table for this command.
CommandRule rule_of(const ClientCommand& command);

}  // namespace fanlight
