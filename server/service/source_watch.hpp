// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "server/command/command_executor.hpp"
#include "server/state/server_state.hpp"
#include "server/stream/session_registry.hpp"

namespace fanlight {

/// Reads the newest state of the probe and of the player of a recording. Logs what has changed, answers
/// changes of the probe, suggests a scene for a probe's geometry, and notifies sessions. Server thread only.
class SourceWatch {
 public:
  /// All must outlive this object.
  SourceWatch(ServerState& state, CommandExecutor& commands, SessionRegistry& sessions)
      : state_(state), commands_(commands), sessions_(sessions) {}

  /// Call this when the acquisition thread may have written a state.
  void update();

 private:
  void probe_changed();
  void replay_changed();

  ServerState& state_;
  CommandExecutor& commands_;
  SessionRegistry& sessions_;
  ProbeStatus logged_;          // the last status that was logged
  std::string replay_trouble_;  // that was logged last
};

}  // namespace fanlight
