// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "server/access/audit_log.hpp"
#include "server/state/recording_proxy.hpp"
#include "server/stream/session_registry.hpp"

namespace fanlight {

/// Notifies sessions, and writes to the log and the audit log what the recorder did. Server thread only.
class RecordingWatch {
 public:
  /// All must outlive this object.
  RecordingWatch(RecordingProxy& recording, SessionRegistry& sessions, AuditLog& audit)
      : recording_(recording), sessions_(sessions), audit_(audit) {}

  /// Call this when the recorder may have written a status. Whether it has.
  bool update();

 private:
  void report_end(const RecordingStatus& status);

  RecordingProxy& recording_;
  SessionRegistry& sessions_;
  AuditLog& audit_;
};

}  // namespace fanlight
