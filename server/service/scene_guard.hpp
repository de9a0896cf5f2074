// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "server/access/audit_log.hpp"
#include "server/state/scene_watch.hpp"
#include "server/state/server_state.hpp"
#include "server/stream/session_registry.hpp"

namespace fanlight {

/// Reports a change of the main view that no picture shows, and withdraws one that the GPU cannot draw:
/// counts and logs it, puts the scene that is shown in force again, and tells the displays why. Server
/// thread only.
class SceneGuard {
 public:
  /// All must outlive this object.
  SceneGuard(ServerState& state, SessionRegistry& sessions, AuditLog& audit)
      : state_(state), sessions_(sessions), audit_(audit) {}

  /// Call it several times a second.
  void update(std::int64_t now_ns);

  /// Why the picture does not show the scene in force after two seconds, a sentence; empty: it does.
  std::string trouble() const;

 private:
  void withdraw();

  ServerState& state_;
  SessionRegistry& sessions_;
  AuditLog& audit_;
  SceneWatch watch_;
};

}  // namespace fanlight
