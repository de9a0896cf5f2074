// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/access/audit_log.hpp"
#include "server/access/control_lease.hpp"
#include "server/access/role.hpp"
#include "server/metrics/server_counters.hpp"
#include "server/state/scene_store.hpp"
#include "server/stream/session_registry.hpp"

namespace fanlight {

/// Carries out commands in PLUS's XML, with the checks and rights that REST has:
///
///   <Command Name="GetParameter"><Parameter Name="light.up_mm"/></Command>    without a Parameter: all
///   <Command Name="SetParameter"><Parameter Name="light.up_mm" Value="20"/></Command>    all of them or none
///
/// The parameters are the fields of the scene. The answer is a CommandReply with the same Name, Status
/// SUCCESS or FAIL, a Message where it failed, and the parameters with their values in force. Server thread
/// only.
class IgtlCommands {
 public:
  /// All must outlive this object.
  struct Dependencies {
    ServerCounters& counters;
    SceneStore& scene_store;
    const ControlLease& control;
    AuditLog& audit;
    SessionRegistry& sessions;
  };
  explicit IgtlCommands(const Dependencies& dependencies) : dependencies_(dependencies) {}

  using Values = std::vector<std::pair<std::string, std::string>>;  ///< by name
  struct Reply {
    bool done = false;
    std::string xml;
  };
  /// The answer to what is no command.
  static std::string refusal(const std::string& why);
  /// `name`: of the message; empty: the Command's own is used.
  Reply carry_out(std::string_view name, std::string_view xml, const Principal& principal);

 private:
  Reply get(const std::vector<std::string>& names) const;
  Reply set(const Values& values, const Principal& principal);
  Values in_force(const std::vector<std::string>& names) const;

  Dependencies dependencies_;
};

}  // namespace fanlight
