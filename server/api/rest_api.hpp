// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <variant>

#include "server/access/audit_log.hpp"
#include "server/access/role.hpp"
#include "server/api/api_query.hpp"
#include "server/api/api_response.hpp"
#include "server/api/archive_sender.hpp"
#include "server/api/operations.hpp"
#include "server/api/picture_files.hpp"
#include "server/api/script_sessions.hpp"
#include "server/command/command_executor.hpp"
#include "server/state/server_state.hpp"
#include "server/stream/picture_hub.hpp"

namespace fanlight {

/// Serves the operations of api_operations(): translates HTTP requests of scripts into commands, and the
/// answers back. A script that shows no control key is never in control, so its changes are refused while a
/// session is. Two operations are served in part by HttpSession: the stream of pictures, and objects for the
/// archive, whose bodies are large. Server thread only.
class RestApi {
 public:
  using Request = ApiRequest;
  using Response = ApiResponse;
  using Answer = std::function<void(Response)>;

  /// All must outlive this object.
  struct Dependencies {
    ServerState& state;
    CommandExecutor& commands;
    PictureHub& hub;
    AuditLog& audit;
    SessionRegistry& sessions;
    ControlLease& control;
    const Authenticator& access;
  };
  explicit RestApi(const Dependencies& dependencies);

  /// Answers a request whose path is_api(), at once or later.
  void serve(const Request& request, const Principal& principal, const Answer& answer, std::int64_t now_ns);

  /// The settings of a stream of pictures that a request asks for; or the refusal. nullopt: the request asks
  /// for something else.
  std::optional<std::variant<StreamSettings, Response>> stream_settings(const Request& request);

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

  /// There may be a new picture.
  void picture_shown(std::int64_t now_ns) { pictures_.answer_waiting(now_ns); }
  void second_passed(std::int64_t now_ns);
  /// The server ends: writes what is left for the audit log.
  void end_scripts() { scripts_.close_all(); }
  /// Lets those who wait go without an answer.
  void abandon();

 private:
  struct Call {
    const Request& request;
    const Principal& principal;
    ApiQuery query{};
    ScriptSession* script = nullptr;  ///< null: no control key was shown
  };
  using Handler = Response (RestApi::*)(const Call&);
  static Handler handler_of(ApiId id);

  /// Whether it was a request for a picture, which is answered later.
  bool serve_picture(ApiId id, const Call& call, const Answer& answer, std::int64_t now_ns);
  /// Sets the control key of a call. Error: it is not valid.
  Result<void> take_key(Call& call, const ApiOperation& operation, std::int64_t now_ns);

  Response list(const Call& call);
  Response describe(const Call& call);
  Response list_fields(const Call& call);
  Response scene(const Call& call);
  Response change_scene(const Call& call);
  Response presets(const Call& call);
  Response change_presets(const Call& call);
  Response measurements(const Call& call);
  Response change_measurements(const Call& call);
  Response control(const Call& call);
  Response change_control(const Call& call);
  Response recording(const Call& call);
  Response change_recording(const Call& call);
  Response replay(const Call& call);
  Response change_replay(const Call& call);
  Response cine(const Call& call);
  Response change_cine(const Call& call);
  Response relay(const Call& call);
  Response change_relay(const Call& call);
  Response archive(const Call& call);

  nlohmann::ordered_json control_json(const ScriptSession* script) const;
  Response ask_for_control(const Call& call, const ChangeControl& command, const std::string& name);
  /// Carries out a command. `done`: makes the response where it was not refused.
  Response execute(const Call& call, const ClientCommand& command,
                   const std::function<Response(const CommandResult&)>& done);
  /// The response to a request that could not be read as a command of this kind: `problem`, where its
  /// principal may give such commands at all.
  Response reject(const Call& call, const ClientCommand& kind, const std::string& reason,
                  Problem problem = Problem::kMalformed, const nlohmann::json& details = nullptr);

  Dependencies dependencies_;
  PictureFiles pictures_;
  ArchiveSender archive_sender_;
  ScriptSessions scripts_;
  std::string description_;  // of this API; empty until the first request for it
};

}  // namespace fanlight
