#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace fanlight {

/// What somebody may do; each may also do what those before it may.
enum class Role : std::uint8_t {
  kViewer,    ///< watch
  kOperator,  ///< change the scene and the probe, one at a time: see ControlDesk
  kAdmin,     ///< take the control from an operator
};

/// "viewer", "operator", "admin".
std::string_view role_name(Role role);
std::optional<Role> find_role(std::string_view name);

/// Who is at the other end of a connection.
struct Visitor {
  Role role = Role::kViewer;
  std::string name;     ///< of the token or the certificate; "loopback" where none is needed
  std::string proof;    ///< id of the token, fingerprint of the certificate; empty where none is needed
  std::string address;  ///< with the port
};

}  // namespace fanlight
