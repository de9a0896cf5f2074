// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "server/access/audit_log.hpp"
#include "server/state/recording_proxy.hpp"
#include "server/stream/session_registry.hpp"

namespace fanlight {

/// Tells displays, the log and the audit log what the recorder did. Server thread only.
class RecordingWatch {
 public:
  /// All must outlive this object.
  struct Dependencies {
    RecordingProxy& proxy;
    SessionRegistry& sessions;
    AuditLog& audit;
  };
  explicit RecordingWatch(const Dependencies& dependencies) : dependencies_(dependencies) {}

  /// Call this when the recorder may have written a status.
  void update();

 private:
  void tell_end(const RecordingStatus& status);

  Dependencies dependencies_;
};

}  // namespace fanlight
