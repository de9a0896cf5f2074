// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "proto/base/printable.hpp"
#include "server/access/control_lease.hpp"
#include "server/access/role.hpp"

namespace fanlight {

inline constexpr std::size_t kLongestNameBytes = 64;

/// Whether the text may appear as a session's name on a page and in a log.
inline bool is_session_name(std::string_view text) {
  return text.size() <= kLongestNameBytes && is_printable(text);
}

/// The client of a session; or a script or an OpenIGTLink client, which have none.
struct SessionIdentity {
  std::uint64_t id = 0;  ///< 0: no session
  std::string address;
  std::optional<Principal> principal;  ///< empty until the client is authenticated
  std::string name;                    ///< as the other sessions see it

  ControlLease::Party party() const { return {.session = id, .name = name}; }
};

}  // namespace fanlight
