// SPDX-License-Identifier: Apache-2.0
#include "server/http/rest_api.hpp"

#include <fmt/format.h>
#include <google/protobuf/util/json_util.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "proto/base/printable.hpp"
#include "server/http/api_response.hpp"
#include "server/http/page_files.hpp"
#include "server/state/scene_json.hpp"
#include "server/stream/shared_page.hpp"

namespace fanlight {

namespace http = boost::beast::http;

namespace {

using nlohmann::json;
using nlohmann::ordered_json;

RestApi::Response no_picture() {
  RestApi::Response response =
      refusal(http::status::service_unavailable, "there is no picture yet, expected a later request");
  response.set(http::field::retry_after, "1");
  return response;
}

RestApi::Response json_text(std::string text) {
  RestApi::Response response(http::status::ok, 11);
  response.set(http::field::content_type, "application/json");
  response.body() = std::move(text);
  return response;
}

ordered_json recording_json(const v1::RecordingStatus& status) {
  return status.available() ? message_json(status) : ordered_json{{"available", false}};
}

ordered_json replay_json(const v1::ReplayStatus& status) {
  ordered_json report = message_json(status);
  if (status.state() == v1::ReplayStatus::NO_RECORDING) return {{"state", report["state"]}};
  report["ending"] = replay_ending_name(status.ending());  // as it is written in a wish
  return report;
}

ordered_json state_json(const NumberedScene& scene) {
  return {{"revision", scene.revision}, {"scene", scene_json(scene.scene)}};
}

/// The HTTP status of a refused command.
http::status status_of(const ClientCommand& command, const CommandResult& result) {
  using Refused = CommandResult::Refused;
  if (result.refused == Refused::kByRole) return http::status::forbidden;
  if (result.refused == Refused::kByControl) return http::status::conflict;
  if (result.refused == Refused::kByAudit) return http::status::service_unavailable;
  if (result.error.code == ErrorCode::kNotFound) return http::status::not_found;
  if (result.error.code != ErrorCode::kInvalidArgument) return http::status::conflict;
  return std::holds_alternative<ChangeScene>(command) ? http::status::unprocessable_entity
                                                      : http::status::bad_request;
}

/// {"done": true}, with the id of a measurement that was added or changed.
RestApi::Response done_with(const v1::MeasurementRequest& request) {
  ordered_json body = {{"done", true}};
  if (request.has_add()) body["id"] = std::to_string(request.add().id());
  if (request.has_rename()) body["id"] = std::to_string(request.rename().id());
  return json_response(http::status::ok, body);
}

/// The member of an object where it is a text; else empty.
std::string text_of(const json& object, const char* key) {
  const auto value = object.is_object() ? object.value(key, json()) : json();
  return value.is_string() ? value.get<std::string>() : std::string();
}

/// {"save": NAME} with or without "scene" and "with_cuts", or {"remove": NAME}.
Result<v1::PresetRequest> preset_request(const json& body) {
  const bool removes = body.is_object() && body.contains("remove");
  if (!body.is_object() || body.contains("save") == removes)
    return Error{ErrorCode::kInvalidArgument, R"(expected {"save": NAME} or {"remove": NAME})"};
  v1::PresetRequest request;
  if (removes) {
    request.set_remove(text_of(body, "remove"));
    return request;
  }
  request.mutable_save()->set_name(text_of(body, "save"));
  if (body.contains("with_cuts")) {
    if (!body["with_cuts"].is_boolean())
      return Error{ErrorCode::kInvalidArgument, "with_cuts: expected true or false"};
    request.set_with_cuts(body["with_cuts"].get<bool>());
  }
  if (body.contains("scene")) {
    auto scene = scene_change_from_json(body["scene"]);
    if (!scene) return scene.error();
    *request.mutable_save()->mutable_scene() = *std::move(scene);
  }
  return request;
}

}  // namespace

RestApi::Response RestApi::respond(const Request& request, std::string_view path,
                                   const Principal& principal) {
  struct Route {
    std::string_view path;
    std::function<Response()> read;
    http::verb change_verb;
    std::function<Response()> change;
  };
  const std::array<Route, 8> routes{{
      {"/api/scene", [&] { return scene(); }, http::verb::patch,
       [&] { return change_scene(request, principal); }},
      {"/api/presets", [&] { return presets(); }, http::verb::post,
       [&] { return change_presets(request, principal); }},
      {"/api/measurements", [&] { return measurements(); }, http::verb::post,
       [&] { return change_measurements(request, principal); }},
      {"/api/recording", [&] { return recording(); }, http::verb::post,
       [&] { return record(request, principal); }},
      {"/api/replay", [&] { return replay(); }, http::verb::post,
       [&] { return control_replay(request, principal); }},
      {"/api/cine", [&] { return cine(); }, http::verb::post,
       [&] { return control_cine(request, principal); }},
      {"/api/rtp", [&] { return relay(principal); }, http::verb::post,
       [&] { return control_relay(request, principal); }},
      // A POST goes to send_object() in place of here; the row says that there is one.
      {"/api/archive", [&] { return archive(); }, http::verb::post, [&] { return archive(); }},
  }};
  if (path == "/api/picture.png" || path == "/api/surface.html") return wrong_method("GET", "GET, HEAD");
  const auto route = std::ranges::find(routes, path, &Route::path);
  if (route == routes.end()) {
    return refusal(http::status::not_found,
                   "there is nothing here, expected /api/scene, /api/picture.png, /api/surface.html, "
                   "/api/presets, /api/measurements, /api/recording, "
                   "/api/replay, /api/cine, /api/rtp or /api/archive");
  }
  if (request.method() == http::verb::get || request.method() == http::verb::head) return route->read();
  if (request.method() == route->change_verb) return is_json(request) ? route->change() : expected_json();
  const std::string verb(http::to_string(route->change_verb));
  return wrong_method("GET or " + verb, "GET, HEAD, " + verb);
}

RestApi::Response RestApi::execute(const Principal& principal, const ClientCommand& command,
                                   const std::function<Response(const CommandResult&)>& done) {
  SessionlessRequester script(dependencies_.audit, principal);
  Response response;
  dependencies_.commands.execute(script.requester(), command, [&](const CommandResult& result) {
    response =
        result ? done(result) : refusal(status_of(command, result), result.error.message, result.field);
  });
  return response;
}

RestApi::Response RestApi::reject(const Principal& principal, const ClientCommand& kind,
                                  const std::string& reason, http::status status, const json& details) {
  SessionlessRequester script(dependencies_.audit, principal);
  const CommandResult result =
      dependencies_.commands.reject(script.requester(), kind, {ErrorCode::kInvalidArgument, reason}, details);
  const bool malformed = result.refused == CommandResult::Refused::kByCommand;
  return refusal(malformed ? status : status_of(kind, result), result.error.message);
}

// ---- the scene

RestApi::Response RestApi::scene() const {
  return json_response(http::status::ok, state_json(dependencies_.state.scene_store.in_force()));
}

RestApi::Response RestApi::change_scene(const Request& request, const Principal& principal) {
  const auto parsed = json::parse(request.body(), nullptr, false);
  if (parsed.is_discarded()) {
    return reject(principal, ChangeScene(),
                  "the body is no JSON, expected an object with fields of the scene");
  }
  const auto change = scene_change_from_json(parsed);
  if (!change)
    return reject(principal, ChangeScene(), change.error().message, http::status::unprocessable_entity);
  return execute(principal, ChangeScene{*change}, [&](const CommandResult&) { return scene(); });
}

// ---- presets

RestApi::Response RestApi::presets() const {
  return json_text(dependencies_.state.presets.json());
}

RestApi::Response RestApi::change_presets(const Request& request, const Principal& principal) {
  const auto body = json::parse(request.body(), nullptr, false);
  const auto wish = preset_request(body);
  if (!wish) {
    const json details =
        text_of(body, "save").empty() ? json() : json{{"save", printable(text_of(body, "save"))}};
    return reject(principal, ChangePresets(), wish.error().message, http::status::bad_request, details);
  }
  return execute(principal, ChangePresets{*wish}, [&](const CommandResult&) { return presets(); });
}

// ---- measurements

RestApi::Response RestApi::measurements() const {
  return json_text(dependencies_.state.measurements.overview());
}

RestApi::Response RestApi::change_measurements(const Request& request, const Principal& principal) {
  ChangeMeasurements command;
  const auto read = google::protobuf::util::JsonStringToMessage(request.body(), &command.request);
  if (!read.ok()) {
    const std::string reason(read.message().data(), std::min<std::size_t>(read.message().size(), 120));
    return reject(
        principal, command,
        fmt::format(R"({}; expected {{"add": MEASUREMENT}}, {{"rename": {{"id": ID, "name": NAME}}}}, )"
                    R"({{"remove": ID}} or {{"remove_all": true}})",
                    printable(reason.substr(0, reason.find('\n')))));
  }
  // So that the answer has it. The list is large, and others may wait.
  if (command.request.has_add() && command.request.add().id() == 0)
    command.request.mutable_add()->set_id(MeasurementStore::random_id());
  return execute(principal, command, [&](const CommandResult&) { return done_with(command.request); });
}

// ---- recorder, replay and cine

RestApi::Response RestApi::recording() const {
  return json_response(http::status::ok, recording_json(dependencies_.state.recording.message()));
}

RestApi::Response RestApi::record(const Request& request, const Principal& principal) {
  const auto wish = recording_wish(wish_text(request));
  if (!wish) {
    return reject(principal, ControlRecorder(),
                  R"(the wish is not known, expected {"wish": "start"}, "stop" or "keep")");
  }
  return execute(principal, ControlRecorder{wish}, [](const CommandResult& result) {
    return json_response(http::status::ok, {{"file", result.file}});
  });
}

RestApi::Response RestApi::replay() const {
  return json_response(http::status::ok, replay_json(dependencies_.state.replay.message()));
}

RestApi::Response RestApi::control_replay(const Request& request, const Principal& principal) {
  const auto wish = replay_request(wish_text(request));
  if (!wish) return reject(principal, ControlReplay(), wish.error().message);
  return execute(principal, ControlReplay{*wish}, [&](const CommandResult&) {
    return json_response(http::status::ok, {{"taken", replay_words(*wish)}});
  });
}

RestApi::Response RestApi::cine() const {
  return json_response(http::status::ok, message_json(dependencies_.state.cine.message()));
}

RestApi::Response RestApi::control_cine(const Request& request, const Principal& principal) {
  const auto wish = cine_request(wish_text(request));
  if (!wish) return reject(principal, ControlCine(), wish.error().message);
  return execute(principal, ControlCine{*wish}, [&](const CommandResult&) {
    return json_response(http::status::ok, {{"taken", cine_words(*wish)}});
  });
}

// ---- the RTP receiver

RestApi::Response RestApi::relay(const Principal& principal) const {
  if (dependencies_.state.relay == nullptr)
    return json_response(http::status::ok, {{"state", "no_receiver"}});
  const RelayReport report = dependencies_.state.relay->report();
  ordered_json body = {
      {"state", report.sending ? "sending" : "stopped"}, {"to", report.to}, {"encrypted", report.encrypted}};
  if (report.reception) {
    body["receiver"] = {{"lost_percent", report.reception->lost_percent},
                        {"lost_packets", report.reception->lost_packets},
                        {"jitter_ms", report.reception->jitter_ms}};
  }
  if (has_role(principal.role, kReadsRelayDescription)) body["sdp"] = report.description;
  return json_response(http::status::ok, body);
}

RestApi::Response RestApi::control_relay(const Request& request, const Principal& principal) {
  const std::string wish = wish_text(request);
  if (wish != "start" && wish != "stop") {
    return reject(principal, ControlRelay(),
                  R"(the wish is not known, expected {"wish": "start"} or "stop")");
  }
  return execute(principal, ControlRelay{.sends = wish == "start"},
                 [&](const CommandResult&) { return relay(principal); });
}

// ---- the archive

RestApi::Response RestApi::archive() const {
  const StillArchive* const archive = dependencies_.state.archive;
  if (archive == nullptr) return json_response(http::status::ok, {{"available", false}});
  const StillArchive::Report report = archive->report();
  return json_response(
      http::status::ok,
      {{"available", report.available}, {"waiting", report.waiting}, {"refused", report.refused}});
}

RestApi::Admission RestApi::admit_object(const Request& header, const Principal& principal) {
  if (!is_json(header)) {
    return {.permit = nullptr,
            .refusal =
                reject(principal, SendStill(), "the body is no JSON, expected Content-Type: application/json",
                       http::status::unsupported_media_type)};
  }
  bool permitted = false;
  Response refused = execute(principal, SendStill(), [&](const CommandResult&) {
    permitted = true;
    return Response();
  });
  auto permit = permitted ? archive_sender_.admit() : nullptr;
  if (permitted && permit == nullptr) {
    constexpr auto kReason = "the last objects are still being written, expected a later request";
    dependencies_.state.counters.archive_refusals.add();
    dependencies_.audit.note(principal, {.what = "archive", .result = std::string("refused: ") + kReason},
                             nullptr);
    refused = refusal(http::status::service_unavailable, kReason);
  }
  if (permit == nullptr) return {.permit = nullptr, .refusal = std::move(refused)};
  return {.permit = std::move(permit)};
}

// ---- pictures

void RestApi::picture(const Principal& principal, const Answer& answer, std::int64_t now_ns) {
  once_rendered(answer, now_ns, [this, principal, answer] { encode_picture(principal, answer); });
}

void RestApi::once_rendered(const Answer& answer, std::int64_t now_ns, const std::function<void()>& then) {
  dependencies_.state.demand.asked(now_ns);
  if (dependencies_.hub.newest_picture() != nullptr) return then();
  const bool is_coming = dependencies_.state.demand.resting() || !waiting_.empty();
  if (!is_coming || waiting_.size() >= PictureHub::kMostFileRequests) return answer(no_picture());
  waiting_.push_back({then, answer, now_ns + kMostWaitNs});
}

void RestApi::shared_surface(const Principal& principal, const Answer& answer, std::int64_t now_ns) {
  if (!has_role(principal.role, kShares)) {
    constexpr auto kReason = "the role may not share surfaces, expected an operator";
    dependencies_.audit.note(principal, {.what = "share", .result = std::string("refused: ") + kReason},
                             nullptr);
    return answer(refusal(http::status::forbidden, kReason));
  }
  once_rendered(answer, now_ns, [this, principal, answer] { make_shared_page(principal, answer); });
}

void RestApi::make_shared_page(const Principal& principal, const Answer& answer) {
  const auto refused = [&](http::status status, const std::string& reason) {
    dependencies_.audit.note(principal, {.what = "share", .result = "refused: " + reason}, nullptr);
    answer(refusal(status, reason));
  };
  const Picture* const newest = dependencies_.hub.newest_picture();
  if (newest == nullptr) return answer(no_picture());
  // Its camera would be another one.
  if (newest->stamp.scene_revision < dependencies_.state.scene_store.in_force().revision)
    return refused(http::status::service_unavailable,
                   "the newest picture does not show the scene in force yet, expected a later request");
  struct Made {
    Result<std::string> html = Error{ErrorCode::kUnavailable, "there is no memory to make the page"};
    std::uint64_t picture_id = 0;
  };
  const auto made = std::make_shared<Made>();
  const auto begun = dependencies_.hub.work_on_newest(
      [made, scene = dependencies_.state.scene_store.in_force().scene,
       usual = dependencies_.state.description.picture_size](const Picture& picture) {
        made->picture_id = picture.stamp.picture_id;
        SharedPage page(shared_page_template(), "", scene);
        if (const auto added = page.add_within(picture, usual); added) {
          made->html = page.html();
        } else {
          made->html = added.error();
        }
      },
      [made, answer, principal, this] {
        const std::string result = made->html ? "done" : "refused: " + made->html.error().message;
        dependencies_.audit.note(principal, {.what = "share", .result = result},
                                 {{"picture", made->picture_id}});
        if (!made->html) return answer(refusal(http::status::conflict, made->html.error().message));
        Response response(http::status::ok, 11);
        response.set(http::field::content_type, "text/html; charset=utf-8");
        response.set(http::field::content_disposition, "attachment; filename=surface.html");
        response.body() = *std::move(made->html);
        answer(std::move(response));
      });
  if (!begun) refused(http::status::service_unavailable, begun.error().message);
}

void RestApi::answer_waiting(std::int64_t now_ns) {
  archive_sender_.end_late(now_ns);
  if (waiting_.empty()) return;
  const bool there_is_one = dependencies_.hub.newest_picture() != nullptr;
  const auto is_due = [&](const Waiting& each) { return there_is_one || now_ns >= each.until_ns; };
  std::vector<Waiting> due;
  for (Waiting& each : waiting_) {
    if (is_due(each)) due.push_back(each);
  }
  std::erase_if(waiting_, is_due);
  for (const Waiting& each : due) {
    if (there_is_one) {
      each.then();
    } else {
      each.answer(no_picture());
    }
  }
}

void RestApi::encode_picture(const Principal& principal, const Answer& answer) {
  dependencies_.hub.png([answer, principal, this](const Result<PictureHub::PictureFile>& file) {
    if (!file) {
      const bool busy = file.error().code == ErrorCode::kUnavailable;
      return answer(refusal(busy ? http::status::service_unavailable : http::status::internal_server_error,
                            file.error().message));
    }
    dependencies_.audit.note(principal, {.what = "picture_read", .result = "done"},
                             {{"picture", file->stamp.picture_id}});
    Response response(http::status::ok, 11);
    response.set(http::field::content_type, "image/png");
    response.set("X-Fanlight-Picture-Id", std::to_string(file->stamp.picture_id));
    response.set("X-Fanlight-Volume-Id", std::to_string(file->stamp.volume.volume_id));
    response.set("X-Fanlight-Scene-Revision", std::to_string(file->stamp.scene_revision));
    response.body() = *file->png;
    answer(std::move(response));
  });
}

}  // namespace fanlight
