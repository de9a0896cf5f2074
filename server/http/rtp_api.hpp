// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "server/access/audit_log.hpp"
#include "server/access/role.hpp"
#include "server/http/api_response.hpp"
#include "server/rtp/rtp_sender.hpp"

namespace fanlight {

/// Requests about the stream that leaves the room, over plain HTTP:
///
///   GET   /api/rtp         whether pictures are sent, where to and how they arrive; for an admin also the
///   SDP POST  /api/rtp         {"wish": "start"} or "stop"; for an admin, and audited
///
/// Server thread only.
class RtpApi {
 public:
  /// All must outlive this object.
  struct Dependencies {
    ServerCounters& counters;
    AuditLog& audit;
    std::optional<RtpSender>& sender;  ///< absent: the server was given no receiver
  };
  explicit RtpApi(const Dependencies& dependencies) : dependencies_(dependencies) {}

  ApiResponse respond(const ApiRequest& request, const Principal& principal);

 private:
  ApiResponse state(const Principal& principal) const;
  ApiResponse carry_out(const ApiRequest& request, const Principal& principal);

  Dependencies dependencies_;
};

}  // namespace fanlight
