// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace fanlight {

/// What a client may do. Each role includes the ones before it.
enum class Role : std::uint8_t {
  kViewer,    ///< watch pictures
  kOperator,  ///< change the scene and the probe, one session at a time: see ControlLease
  kAdmin,     ///< take control from an operator
};

/// "viewer", "operator", "admin".
std::string_view role_name(Role role);
std::optional<Role> find_role(std::string_view name);

/// The authenticated client of a connection.
struct Principal {
  Role role = Role::kViewer;
  std::string name;     ///< of the token or the certificate; "loopback" if none is needed
  std::string proof;    ///< id of the token, fingerprint of the certificate; empty if none is needed
  std::string address;  ///< with the port
};

}  // namespace fanlight
