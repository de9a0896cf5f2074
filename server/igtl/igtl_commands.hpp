// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/access/audit_log.hpp"
#include "server/access/role.hpp"
#include "server/command/command_executor.hpp"
#include "server/state/server_state.hpp"

namespace fanlight {

/// Translates commands in PLUS's XML, and the answers back:
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
    ServerState& state;
    CommandExecutor& commands;
    AuditLog& audit;
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
