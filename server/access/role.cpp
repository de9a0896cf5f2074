// SPDX-License-Identifier: Apache-2.0
#include "server/access/role.hpp"

#include <algorithm>
#include <array>

namespace fanlight {

namespace {

constexpr std::array<std::string_view, 3> kNames = {"viewer", "operator", "admin"};

}  // namespace

std::string_view role_name(Role role) {
  return kNames[static_cast<std::size_t>(role)];
}

std::optional<Role> find_role(std::string_view name) {
  const auto found = std::ranges::find(kNames, name);
  if (found == kNames.end()) return std::nullopt;
  return static_cast<Role>(found - kNames.begin());
}

}  // namespace fanlight
