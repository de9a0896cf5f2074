// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "server/access/audit_log.hpp"
#include "server/access/role.hpp"
#include "server/api/api_query.hpp"
#include "server/api/api_response.hpp"
#include "server/state/server_state.hpp"
#include "server/stream/picture_hub.hpp"

namespace fanlight {

/// Answers requests for the newest picture of the main view as a file. Where there is none, since the server
/// has just started or there were no viewers, the request waits for one: for kMostWaitNs, then it is refused.
/// Server thread only.
class PictureFiles {
 public:
  using Answer = std::function<void(ApiResponse)>;
  static constexpr std::int64_t kMostWaitNs = 5'000'000'000;

  /// All must outlive this object.
  PictureFiles(ServerState& state, PictureHub& hub, AuditLog& audit)
      : state_(state), hub_(hub), audit_(audit) {}

  /// `query`: the revision of the scene that it must show.
  void png(const ApiQuery& query, const Principal& principal, const Answer& answer, std::int64_t now_ns);

  /// `query`: also size and quality. Where the picture is not live, words in it say so.
  void jpeg(const ApiQuery& query, const Principal& principal, const Answer& answer, std::int64_t now_ns);

  /// A page that shows the surface without this server. For operators; audited.
  void shared_surface(const Principal& principal, const Answer& answer, std::int64_t now_ns);

  /// Answers those who wait for a picture, where there is one now, or where they have waited long enough.
  /// Call it after every picture, and once a second.
  void answer_waiting(std::int64_t now_ns);
  /// Lets those who wait go without an answer: the server ends.
  void abandon() { waiting_.clear(); }

 private:
  struct Waiting {
    std::function<void()> then;  // with a picture
    Answer answer;               // without one
    std::int64_t until_ns = 0;
    std::uint64_t revision = 0;  // of the scene, that the picture must show
  };
  /// Whether there is a picture that shows this revision of the scene.
  bool shows(std::uint64_t revision) const;
  /// Calls `then` once there is, or `answer` with a refusal.
  void once_rendered(std::uint64_t revision, const Answer& answer, std::int64_t now_ns,
                     const std::function<void()>& then);
  void encode(const StreamSettings& settings, const char* media_type, const Principal& principal,
              const Answer& answer);
  void make_shared_page(const Principal& principal, const Answer& answer);

  ServerState& state_;
  PictureHub& hub_;
  AuditLog& audit_;
  std::vector<Waiting> waiting_;
};

}  // namespace fanlight
