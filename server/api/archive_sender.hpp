// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "proto/base/result.hpp"
#include "server/access/audit_log.hpp"
#include "server/access/role.hpp"
#include "server/api/api_response.hpp"
#include "server/state/server_state.hpp"

namespace fanlight {

/// Puts what displays and scripts send into the queue for an archive: stills, clips, and the volume on show.
/// Server thread only.
class ArchiveSender {
 public:
  using Answer = std::function<void(ApiResponse)>;
  /// One of kMostRequests, until the last copy ends.
  using Permit = std::shared_ptr<void>;
  static constexpr std::size_t kMostRequests = 4;

  ArchiveSender(ServerState& state, AuditLog& audit) : state_(state), audit_(audit) {}

  /// Null: there are kMostRequests.
  Permit admit();
  std::size_t under_way() const { return *under_way_; }

  /// `body`: as StillArchive::add(), or a volume: {"volume": "shown", or the number of the one that must be
  /// on show, "patient": {...}}. Answers once it is on the disk, or was refused. Audited, without the
  /// patient. Precondition: state.archive is set.
  void send(std::string body, const Principal& principal, const Permit& permit, const Answer& answer);

  /// Refuses a volume that the renderer has not copied in time. Call it once a second.
  void end_late(std::int64_t now_ns);
  /// Ends all requests without an answer: they hold connections, which must end before the loop.
  void abandon() { requests_.clear(); }

 private:
  struct Request {
    Principal principal;
    Permit permit;
    Answer answer;
    std::size_t bytes = 0;
    std::string volume_body{};  // until the volume is copied; else empty
    nlohmann::json wanted{};    // "shown" or a number
    std::int64_t until_ns = 0;  // until when the copy is waited for; 0: it is not
  };
  using Requests = std::map<std::uint64_t, Request>;

  void send_volume(std::uint64_t number, Request& request);
  void copied(std::uint64_t number, const VolumeCopier::Copy& copy);
  void added(std::uint64_t number, const Result<ArchivedObject>& result);
  void refuse(std::uint64_t number, boost::beast::http::status status, const std::string& sentence);
  void end(std::uint64_t number, const std::string& result, const char* object, ApiResponse response);

  ServerState& state_;
  AuditLog& audit_;
  // Callbacks hold the numbers alone: they may outlast this object, and the connections of the answers.
  Requests requests_;
  std::uint64_t last_number_ = 0;
  std::uint64_t volume_ = 0;  // the request whose volume is under way; 0: none
  // Apart, because a permit may end after this object.
  std::shared_ptr<std::atomic<std::size_t>> under_way_ = std::make_shared<std::atomic<std::size_t>>(0);
};

}  // namespace fanlight
