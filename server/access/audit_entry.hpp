// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "server/access/role.hpp"

namespace fanlight {

/// What one line of the audit log is about.
struct AuditEvent {
  const char* what = "";      ///< name of the event, a literal: "login", "scene_change", ...
  std::uint64_t session = 0;  ///< 0: none
  std::string result;         ///< "done", or the reason of the failure, which begins with "refused"
};

/// Whether the server refused what was asked for.
bool is_refusal(const AuditEvent& event);

/// Whether the event changed who is in control, the scene or the probe.
bool is_act_of_control(const AuditEvent& event);

/// The members of a line as JSON, without braces, from the time on: all but the number of the line and the
/// hash that it follows. Text from outside is made printable().
std::string audit_fields(const Principal& who, const AuditEvent& event, const nlohmann::json& details);

/// The same for an entry of the log about itself.
std::string audit_fields_of_log(const std::string& result, const nlohmann::json& details);

}  // namespace fanlight
