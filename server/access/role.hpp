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

/// Whether `role` is `least`, or includes it.
constexpr bool has_role(Role role, Role least) {
  return role >= least;
}

// Least roles for reading and encodings. Those of commands: server/command/command_rules.cpp.
inline constexpr Role kReadsSourcePath = Role::kAdmin;        ///< it may name a patient
inline constexpr Role kShares = Role::kOperator;              ///< makes files that leave the server
inline constexpr Role kReadsRelayDescription = Role::kAdmin;  ///< it may hold the key of the stream
inline constexpr Role kReplacesAdminsPresets = Role::kAdmin;
inline constexpr Role kEncodesUnlimited = Role::kOperator;  ///< see PictureSubscriber::privileged()

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
