// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/access/audit_log.hpp"
#include "server/access/role.hpp"
#include "server/command/command_executor.hpp"
#include "server/http/api_response.hpp"
#include "server/http/archive_sender.hpp"
#include "server/state/server_state.hpp"
#include "server/stream/picture_hub.hpp"

namespace fanlight {

/// Translates HTTP requests of scripts into commands, and the answers back. A script is never in control, so
/// its changes are refused while a session is:
///
///   GET   /api/scene         the scene in force, as JSON
///   PATCH /api/scene         changes some of its fields: {"light": {"up_mm": 20}}
///   GET   /api/picture.png   the newest picture of the main view
///   GET   /api/presets       the presets that were saved, as JSON
///   POST  /api/presets       {"save": "my face"}, with or without "scene": {...}; or {"remove": "my face"}
///   GET   /api/recording     the state of the recorder, as JSON
///   POST  /api/recording     {"wish": "start"}, "stop" or "keep": the name of the file
///   GET   /api/replay        the state of the player of a recording, as JSON
///   POST  /api/replay        {"wish": "pause"}, "play", "step=-1", "seek=3.5", ...: see replay_request()
///   GET   /api/cine          which of the last volumes is on show, as JSON
///   POST  /api/cine          {"wish": "freeze"}, "live", "play", "step=-1", ...: see cine_request()
///   GET   /api/rtp           the RTP receiver: whether pictures are sent, how they arrive; for an admin, SDP
///   POST  /api/rtp           {"wish": "start"} or "stop"; for an admin
///   GET   /api/archive       whether objects can be sent to an archive, and how many wait, as JSON
///   POST  /api/archive       puts a still, a clip or the volume on show into the queue; for an operator
///
/// Server thread only.
class RestApi {
 public:
  using Request = ApiRequest;
  using Response = ApiResponse;

  /// All must outlive this object.
  struct Dependencies {
    ServerState& state;
    CommandExecutor& commands;
    PictureHub& hub;
    AuditLog& audit;
  };
  using Answer = std::function<void(Response)>;
  explicit RestApi(const Dependencies& dependencies)
      : dependencies_(dependencies), archive_sender_(dependencies.state, dependencies.audit) {}

  /// `path`: of the request, from "/api/" on, without the query.
  Response respond(const Request& request, std::string_view path, const Principal& principal);

  /// The answer to a GET of /api/picture.png, once the picture is encoded. Where nothing was rendered, since
  /// there were no viewers, a picture is rendered first: within kMostWaitNs, or the answer is a refusal.
  void picture(const Principal& principal, const Answer& answer, std::int64_t now_ns);
  static constexpr std::int64_t kMostWaitNs = 5'000'000'000;

  /// The answer to a GET of /api/surface.html: a page that shows the surface of the newest picture without
  /// this server. For operators; audited. Waits for a picture as picture() does.
  void shared_surface(const Principal& principal, const Answer& answer, std::int64_t now_ns);

  struct Admission {
    ArchiveSender::Permit permit;  ///< null: refused
    std::optional<Response> refusal{};
  };
  /// Judges the header of a POST of /api/archive: its body is large.
  Admission admit_object(const Request& header, const Principal& principal);
  /// The answer to it, once the object is on the disk. See ArchiveSender::send().
  void send_object(std::string body, const Principal& principal, const ArchiveSender::Permit& permit,
                   const Answer& answer) {
    archive_sender_.send(std::move(body), principal, permit, answer);
  }
  std::size_t objects_under_way() const { return archive_sender_.under_way(); }

  /// Answers those who wait for a picture, where there is one now, or where they have waited long enough.
  /// Call it after every picture, and once a second.
  void answer_waiting(std::int64_t now_ns);
  /// Lets those who wait go without an answer: the server ends.
  void abandon() {
    waiting_.clear();
    archive_sender_.abandon();
  }

 private:
  Response scene() const;
  Response recording() const;
  Response replay() const;
  Response cine() const;
  Response presets() const;
  Response measurements() const;
  Response relay(const Principal& principal) const;
  Response archive() const;
  Response change_scene(const Request& request, const Principal& principal);
  Response record(const Request& request, const Principal& principal);
  Response control_replay(const Request& request, const Principal& principal);
  Response control_cine(const Request& request, const Principal& principal);
  Response change_presets(const Request& request, const Principal& principal);
  Response change_measurements(const Request& request, const Principal& principal);
  Response control_relay(const Request& request, const Principal& principal);
  /// Carries out a command. `done`: makes the response where it was not refused.
  Response execute(const Principal& principal, const ClientCommand& command,
                   const std::function<Response(const CommandResult&)>& done);
  /// The response to a request that could not be read as a command of this kind: `status`, where its
  /// principal may give such commands at all.
  Response reject(const Principal& principal, const ClientCommand& kind, const std::string& reason,
                  boost::beast::http::status status = boost::beast::http::status::bad_request,
                  const nlohmann::json& details = nullptr);

  struct Waiting {
    std::function<void()> then;  // with a picture
    Answer answer;               // without one
    std::int64_t until_ns = 0;
  };
  /// Calls `then` once there is a picture, or `answer` with a refusal.
  void once_rendered(const Answer& answer, std::int64_t now_ns, const std::function<void()>& then);
  void encode_picture(const Principal& principal, const Answer& answer);
  void make_shared_page(const Principal& principal, const Answer& answer);

  Dependencies dependencies_;
  std::vector<Waiting> waiting_;
  ArchiveSender archive_sender_;
};

}  // namespace fanlight
