// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "server/access/role.hpp"
#include "server/state/preset_store.hpp"

namespace fanlight {

/// Whoever is logged in, as the author of a preset.
inline PresetStore::Author preset_author(const Principal& principal) {
  return {.name = principal.name, .is_admin = principal.role == Role::kAdmin};
}

}  // namespace fanlight
