// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "server/access/audit_log.hpp"
#include "server/access/authenticator.hpp"
#include "server/http/connection_listener.hpp"

namespace fanlight {

/// Reads tokens and certificates again while the server runs; logs and audits it. Server thread only.
class AccessFiles {
 public:
  /// All must outlive this object.
  AccessFiles(Authenticator& access, ConnectionListener& listener, AuditLog& audit)
      : access_(access), listener_(listener), audit_(audit) {}

  /// Reads the files that have changed; `in_any_case`: also those that have not.
  void reload(bool in_any_case);

 private:
  Authenticator& access_;
  ConnectionListener& listener_;
  AuditLog& audit_;
};

}  // namespace fanlight
