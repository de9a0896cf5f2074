// SPDX-License-Identifier: Apache-2.0
#include "server/api/rest_api.hpp"

#include <fmt/format.h>
#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <nlohmann/json.hpp>

#include "proto/base/clock.hpp"
#include "proto/base/printable.hpp"
#include "server/api/json_body.hpp"
#include "server/api/open_api.hpp"
#include "server/api/schemas.hpp"
#include "server/state/scene_json.hpp"
#include "server/state/scene_message.hpp"

namespace fanlight {

namespace http = boost::beast::http;

namespace {

using nlohmann::json;
using nlohmann::ordered_json;

RestApi::Response json_text(std::string text) {
  RestApi::Response response(http::status::ok, 11);
  response.set(http::field::content_type, "application/json");
  response.body() = std::move(text);
  return response;
}

RestApi::Response taken(const std::string& wish) {
  return json_response(http::status::accepted, {{"taken", wish}});
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

Problem problem_with(const CommandResult& result) {
  using Refused = CommandResult::Refused;
  if (result.refused == Refused::kByRole) return Problem::kNotPermitted;
  if (result.refused == Refused::kByControl) return Problem::kControlHeld;
  if (result.refused == Refused::kByAudit) return Problem::kUnavailable;
  if (result.field != nullptr) return Problem::kValueNotAllowed;
  if (result.error.code == ErrorCode::kNotFound) return Problem::kNotFound;
  return result.error.code == ErrorCode::kInvalidArgument ? Problem::kMalformed : Problem::kNotPossibleNow;
}

RestApi::Response refused(const ClientCommand& command, const CommandResult& result, bool has_key) {
  Problem problem = problem_with(result);
  // Rules of several fields name none of them.
  if (problem == Problem::kMalformed && std::holds_alternative<ChangeScene>(command))
    problem = Problem::kValueNotAllowed;
  std::string sentence = result.error.message;
  if (problem == Problem::kControlHeld) {
    sentence += has_key ? "; the key shown may wait for it, GET /api/control says so"
                        : R"(, by POST /api/control {"wish": "ask"})";
  }
  return refusal(problem, sentence, result.field);
}

/// {"done": true}, with the id of a measurement that was added or changed.
RestApi::Response done_with(const v1::MeasurementRequest& request) {
  ordered_json body = {{"done", true}};
  if (request.has_add()) body["id"] = std::to_string(request.add().id());
  if (request.has_rename()) body["id"] = std::to_string(request.rename().id());
  return json_response(http::status::ok, body);
}

/// The text of {"wish": WORD}; empty where it has none. Error: as object_with_keys().
Result<std::string> wish_of(const ApiRequest& request) {
  static constexpr std::string_view kKeys[] = {"wish"};
  const auto body = object_with_keys(request.body(), kKeys);
  if (!body) return body.error();
  return text_of(*body, "wish");
}

/// {"save": NAME} with or without "scene" and "with_cuts", or {"remove": NAME}. The error of a scene is
/// kUnsupported.
Result<v1::PresetRequest> preset_request(const std::string& text) {
  static constexpr std::string_view kKeys[] = {"save", "scene", "with_cuts", "remove"};
  const auto body = object_with_keys(text, kKeys);
  if (!body) return body.error();
  const bool removes = body->contains("remove");
  if (body->contains("save") == removes || (removes && body->size() > 1))
    return Error{ErrorCode::kInvalidArgument, R"(expected {"save": NAME} or {"remove": NAME})"};
  v1::PresetRequest request;
  if (removes) {
    request.set_remove(text_of(*body, "remove"));
    return request;
  }
  request.mutable_save()->set_name(text_of(*body, "save"));
  if (body->contains("with_cuts")) {
    if (!(*body)["with_cuts"].is_boolean())
      return Error{ErrorCode::kInvalidArgument, "with_cuts: expected true or false"};
    request.set_with_cuts((*body)["with_cuts"].get<bool>());
  }
  if (body->contains("scene")) {
    auto scene = scene_change_from_json((*body)["scene"]);
    const auto checked = scene ? changed_scene(Scene{}, *scene) : Result<Scene>(scene.error());
    if (!checked) return Error{ErrorCode::kUnsupported, checked.error().message};
    *request.mutable_save()->mutable_scene() = *std::move(scene);
  }
  return request;
}

/// "ask", "take_over", "keep", "release" or "grant=SESSION".
std::optional<ChangeControl> control_wish(std::string_view text) {
  using Wish = v1::ControlRequest;
  static constexpr std::pair<std::string_view, Wish::Wish> kWishes[] = {
      {"ask", Wish::ASK}, {"take_over", Wish::TAKE_OVER}, {"keep", Wish::KEEP}, {"release", Wish::RELEASE}};
  for (const auto& [word, wish] : kWishes)
    if (text == word) return ChangeControl{.wish = wish};
  constexpr std::string_view kGrant = "grant=";
  if (!text.starts_with(kGrant)) return std::nullopt;
  text.remove_prefix(kGrant.size());
  ChangeControl grant{.wish = Wish::GRANT};
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), grant.to_session);
  if (failure != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return grant;
}

ordered_json party_json(const ControlLease::Party& party) {
  return {{"session", party.session}, {"name", party.name}};
}

}  // namespace

RestApi::RestApi(const Dependencies& dependencies)
    : dependencies_(dependencies),
      pictures_(dependencies.state, dependencies.hub, dependencies.audit),
      archive_sender_(dependencies.state, dependencies.audit),
      scripts_({.sessions = dependencies.sessions,
                .commands = dependencies.commands,
                .control = dependencies.control,
                .access = dependencies.access,
                .audit = dependencies.audit}) {}

RestApi::Handler RestApi::handler_of(ApiId id) {
  // In the order of ApiId; null: see serve_picture(), stream_settings() and send_object().
  static constexpr std::array<Handler, 25> kHandlers = {&RestApi::list,
                                                        &RestApi::describe,
                                                        &RestApi::list_fields,
                                                        &RestApi::scene,
                                                        &RestApi::change_scene,
                                                        nullptr,
                                                        nullptr,
                                                        nullptr,
                                                        nullptr,
                                                        &RestApi::presets,
                                                        &RestApi::change_presets,
                                                        &RestApi::measurements,
                                                        &RestApi::change_measurements,
                                                        &RestApi::control,
                                                        &RestApi::change_control,
                                                        &RestApi::recording,
                                                        &RestApi::change_recording,
                                                        &RestApi::replay,
                                                        &RestApi::change_replay,
                                                        &RestApi::cine,
                                                        &RestApi::change_cine,
                                                        &RestApi::relay,
                                                        &RestApi::change_relay,
                                                        &RestApi::archive,
                                                        nullptr};
  static_assert(kHandlers.size() == static_cast<std::size_t>(ApiId::kSendToArchive) + 1);
  return kHandlers.at(static_cast<std::size_t>(id));
}

void RestApi::serve(const Request& request, const Principal& principal, const Answer& answer,
                    std::int64_t now_ns) {
  const std::string_view target = request.target();
  const std::string_view path = target.substr(0, target.find('?'));
  const ApiOperation* const operation = find_operation(request.method(), path);
  if (operation == nullptr) {
    const std::string allowed = allowed_methods(path);
    return answer(allowed.empty() ? refusal(Problem::kNotFound,
                                            "there is nothing here, expected a path that GET /api lists")
                                  : wrong_method(allowed, allowed));
  }
  auto query = parse_query(target, operation->query);
  if (!query) return answer(refusal(Problem::kMalformed, query.error().message));
  if (!operation->request_schema.empty() && !is_json(request)) return answer(expected_json());
  Call call{.request = request, .principal = principal, .query = *std::move(query)};
  if (const auto key = take_key(call, *operation, now_ns); !key)
    return answer(refusal(Problem::kControlLapsed, key.error().message));
  if (serve_picture(operation->id, call, answer, now_ns)) return;
  const Handler handler = handler_of(operation->id);
  answer(handler != nullptr ? (this->*handler)(call) : archive(call));
}

bool RestApi::serve_picture(ApiId id, const Call& call, const Answer& answer, std::int64_t now_ns) {
  switch (id) {
    case ApiId::kReadPicturePng:
      pictures_.png(call.query, call.principal, answer, now_ns);
      return true;
    case ApiId::kReadPictureJpeg:
      pictures_.jpeg(call.query, call.principal, answer, now_ns);
      return true;
    case ApiId::kReadSurfacePage:
      pictures_.shared_surface(call.principal, answer, now_ns);
      return true;
    default:
      return false;
  }
}

Result<void> RestApi::take_key(Call& call, const ApiOperation& operation, std::int64_t now_ns) {
  const std::string_view key = call.request[kControlKeyHeader];
  if (key.empty() || !operation.takes_control_key) return {};
  call.script = scripts_.find(key, call.principal, now_ns);
  if (call.script != nullptr) return {};
  return Error{
      ErrorCode::kInvalidArgument,
      R"(the control key is not known or has lapsed, expected POST /api/control {"wish": "ask"} without one)"};
}

std::optional<std::variant<StreamSettings, RestApi::Response>> RestApi::stream_settings(
    const Request& request) {
  using Asked = std::variant<StreamSettings, Response>;
  const std::string_view target = request.target();
  const ApiOperation* const operation = find_operation(request.method(), target.substr(0, target.find('?')));
  if (operation == nullptr || operation->id != ApiId::kStreamPictures) return std::nullopt;
  const auto query = parse_query(target, operation->query);
  const auto settings = query ? jpeg_settings(*query, dependencies_.state.description.jpeg_quality)
                              : Result<StreamSettings>(query.error());
  if (!settings) return Asked(refusal(Problem::kMalformed, settings.error().message));
  return Asked(*settings);
}

RestApi::Response RestApi::execute(const Call& call, const ClientCommand& command,
                                   const std::function<Response(const CommandResult&)>& done) {
  SessionlessRequester once(dependencies_.audit, call.principal);
  Response response;
  dependencies_.commands.execute(call.script != nullptr ? call.script->requester() : once.requester(),
                                 command, [&](const CommandResult& result) {
                                   response = result ? done(result)
                                                     : refused(command, result, call.script != nullptr);
                                 });
  return response;
}

RestApi::Response RestApi::reject(const Call& call, const ClientCommand& kind, const std::string& reason,
                                  Problem problem, const json& details) {
  SessionlessRequester once(dependencies_.audit, call.principal);
  const CommandResult result =
      dependencies_.commands.reject(call.script != nullptr ? call.script->requester() : once.requester(),
                                    kind, {ErrorCode::kInvalidArgument, reason}, details);
  const bool malformed = result.refused == CommandResult::Refused::kByCommand;
  return malformed ? refusal(problem, result.error.message) : refused(kind, result, call.script != nullptr);
}

void RestApi::second_passed(std::int64_t now_ns) {
  archive_sender_.end_late(now_ns);
  pictures_.answer_waiting(now_ns);
  scripts_.second_passed(now_ns);
}

void RestApi::abandon() {
  pictures_.abandon();
  archive_sender_.abandon();
}

// ---- the API itself

RestApi::Response RestApi::list(const Call& /*call*/) {
  return json_response(http::status::ok, operation_list());
}

RestApi::Response RestApi::describe(const Call& /*call*/) {
  if (description_.empty()) description_ = open_api().dump(1) + "\n";
  return json_text(description_);
}

RestApi::Response RestApi::list_fields(const Call& /*call*/) {
  ordered_json fields = ordered_json::array();
  for (const SceneField& each : scene_fields()) fields.push_back(field_json(each));
  return json_response(http::status::ok, {{"fields", fields}});
}

// ---- the scene

RestApi::Response RestApi::scene(const Call& /*call*/) {
  const NumberedScene& in_force = dependencies_.state.scene_store.in_force();
  return json_response(http::status::ok,
                       {{"revision", in_force.revision}, {"scene", scene_json(in_force.scene)}});
}

RestApi::Response RestApi::change_scene(const Call& call) {
  const auto parsed = json::parse(call.request.body(), nullptr, false);
  if (parsed.is_discarded()) {
    return reject(call, ChangeScene(), "the body is no JSON, expected an object with fields of the scene");
  }
  const auto change = scene_change_from_json(parsed);
  if (!change) return reject(call, ChangeScene(), change.error().message, Problem::kValueNotAllowed);
  return execute(call, ChangeScene{*change}, [&](const CommandResult&) { return scene(call); });
}

// ---- presets

RestApi::Response RestApi::presets(const Call& /*call*/) {
  return json_text(dependencies_.state.presets.json());
}

RestApi::Response RestApi::change_presets(const Call& call) {
  const auto wish = preset_request(call.request.body());
  if (!wish) {
    const bool of_scene = wish.error().code == ErrorCode::kUnsupported;
    return reject(call, ChangePresets(), wish.error().message,
                  of_scene ? Problem::kValueNotAllowed : Problem::kMalformed);
  }
  return execute(call, ChangePresets{*wish}, [&](const CommandResult&) { return presets(call); });
}

// ---- measurements

RestApi::Response RestApi::measurements(const Call& /*call*/) {
  return json_text(dependencies_.state.measurements.overview());
}

RestApi::Response RestApi::change_measurements(const Call& call) {
  static constexpr std::string_view kKeys[] = {"add", "rename", "remove", "remove_all"};
  ChangeMeasurements command;
  const auto body = object_with_keys(call.request.body(), kKeys);
  if (!body) return reject(call, command, body.error().message);
  const auto read = google::protobuf::util::JsonStringToMessage(call.request.body(), &command.request);
  if (!read.ok()) {
    const std::string reason(read.message().data(), std::min<std::size_t>(read.message().size(), 120));
    return reject(
        call, command,
        fmt::format(R"({}; expected {{"add": MEASUREMENT}}, {{"rename": {{"id": ID, "name": NAME}}}}, )"
                    R"({{"remove": ID}} or {{"remove_all": true}})",
                    printable(reason.substr(0, reason.find('\n')))));
  }
  // So that the answer has it. The list is large, and others may wait.
  if (command.request.has_add() && command.request.add().id() == 0)
    command.request.mutable_add()->set_id(MeasurementStore::random_id());
  return execute(call, command, [&](const CommandResult&) { return done_with(command.request); });
}

// ---- control

ordered_json RestApi::control_json(const ScriptSession* script) const {
  const ControlLease& lease = dependencies_.control;
  const ControlLease::State& state = lease.state();
  ordered_json asking = ordered_json::array();
  for (const ControlLease::Party& each : state.asking) asking.push_back(party_json(each));
  const std::uint64_t id = script != nullptr ? script->id() : 0;
  ordered_json body = {
      {"holder", state.holder.session == 0 ? ordered_json() : party_json(state.holder)},
      {"asking", asking},
      {"lapses_after_s", static_cast<double>(lease.lapse_ms()) / 1000},
      {"mine", lease.holds(id)},
      {"waiting", std::ranges::find(state.asking, id, &ControlLease::Party::session) != state.asking.end()}};
  if (script != nullptr) body["session"] = id;
  return body;
}

RestApi::Response RestApi::control(const Call& call) {
  return json_response(http::status::ok, control_json(call.script));
}

RestApi::Response RestApi::change_control(const Call& call) {
  static constexpr std::string_view kKeys[] = {"wish", "name"};
  const auto body = object_with_keys(call.request.body(), kKeys);
  if (!body) return reject(call, ChangeControl(), body.error().message);
  const auto command = control_wish(text_of(*body, "wish"));
  if (!command) {
    return reject(call, ChangeControl(),
                  R"(the wish is not known, expected {"wish": "ask"}, "take_over", "keep", "release" or )"
                  R"("grant=SESSION")");
  }
  const bool begins =
      command->wish == v1::ControlRequest::ASK || command->wish == v1::ControlRequest::TAKE_OVER;
  if (call.script == nullptr && begins) {
    if (body->contains("name") && !(*body)["name"].is_string())
      return reject(call, *command, "name: expected a text");
    return ask_for_control(call, *command, text_of(*body, "name"));
  }
  if (body->contains("name"))
    return reject(call, *command, "the name is set by the first wish, expected none with a control key");
  if (call.script == nullptr) {
    return reject(call, *command,
                  fmt::format("the request shows no control key, expected the header {}", kControlKeyHeader));
  }
  const bool ends = command->wish == v1::ControlRequest::RELEASE;
  bool released = false;
  Response response = execute(call, *command, [&](const CommandResult&) {
    released = ends;
    return json_response(http::status::ok, control_json(ends ? nullptr : call.script));
  });
  if (released) scripts_.close(*call.script);
  return response;
}

RestApi::Response RestApi::ask_for_control(const Call& call, const ChangeControl& command,
                                           const std::string& name) {
  const auto opened = scripts_.open(call.principal, name, now_ns());
  if (!opened) {
    const bool is_full = opened.error().code == ErrorCode::kUnavailable;
    return reject(call, command, opened.error().message,
                  is_full ? Problem::kUnavailable : Problem::kMalformed);
  }
  ScriptSession& script = **opened;
  bool done = false;
  const Call with_key{.request = call.request, .principal = call.principal, .script = &script};
  Response response = execute(with_key, command, [&](const CommandResult&) {
    done = true;
    ordered_json body = control_json(&script);
    body["key"] = script.key();
    return json_response(http::status::ok, body);
  });
  if (!done) scripts_.close(script);
  return response;
}

// ---- recorder, replay and cine

RestApi::Response RestApi::recording(const Call& /*call*/) {
  return json_response(http::status::ok, recording_json(dependencies_.state.recording.message()));
}

RestApi::Response RestApi::change_recording(const Call& call) {
  const auto text = wish_of(call.request);
  if (!text) return reject(call, ControlRecorder(), text.error().message);
  const auto wish = recording_wish(*text);
  if (!wish) {
    return reject(call, ControlRecorder(),
                  R"(the wish is not known, expected {"wish": "start"}, "stop" or "keep")");
  }
  return execute(call, ControlRecorder{wish}, [](const CommandResult& result) {
    return json_response(http::status::ok, {{"file", result.file}});
  });
}

RestApi::Response RestApi::replay(const Call& /*call*/) {
  return json_response(http::status::ok, replay_json(dependencies_.state.replay.message()));
}

RestApi::Response RestApi::change_replay(const Call& call) {
  const auto text = wish_of(call.request);
  const auto wish = text ? replay_request(*text) : Result<v1::ReplayRequest>(text.error());
  if (!wish) return reject(call, ControlReplay(), wish.error().message);
  return execute(call, ControlReplay{*wish},
                 [&](const CommandResult&) { return taken(replay_words(*wish)); });
}

RestApi::Response RestApi::cine(const Call& /*call*/) {
  return json_response(http::status::ok, message_json(dependencies_.state.cine.message()));
}

RestApi::Response RestApi::change_cine(const Call& call) {
  const auto text = wish_of(call.request);
  const auto wish = text ? cine_request(*text) : Result<v1::CineRequest>(text.error());
  if (!wish) return reject(call, ControlCine(), wish.error().message);
  return execute(call, ControlCine{*wish}, [&](const CommandResult&) { return taken(cine_words(*wish)); });
}

// ---- the RTP receiver

RestApi::Response RestApi::relay(const Call& call) {
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
  if (has_role(call.principal.role, kReadsRelayDescription)) body["sdp"] = report.description;
  return json_response(http::status::ok, body);
}

RestApi::Response RestApi::change_relay(const Call& call) {
  const auto wish = wish_of(call.request);
  if (!wish) return reject(call, ControlRelay(), wish.error().message);
  if (*wish != "start" && *wish != "stop") {
    return reject(call, ControlRelay(), R"(the wish is not known, expected {"wish": "start"} or "stop")");
  }
  return execute(call, ControlRelay{.sends = *wish == "start"},
                 [&](const CommandResult&) { return relay(call); });
}

// ---- the archive

RestApi::Response RestApi::archive(const Call& /*call*/) {
  const StillArchive* const archive = dependencies_.state.archive;
  if (archive == nullptr) return json_response(http::status::ok, {{"available", false}});
  const StillArchive::Report report = archive->report();
  return json_response(
      http::status::ok,
      {{"available", report.available}, {"waiting", report.waiting}, {"refused", report.refused}});
}

RestApi::Admission RestApi::admit_object(const Request& header, const Principal& principal) {
  const Call call{.request = header, .principal = principal};
  if (!is_json(header)) {
    return {
        .permit = nullptr,
        .refusal = reject(call, SendStill(), "the body is no JSON, expected Content-Type: application/json",
                          Problem::kMediaType)};
  }
  bool permitted = false;
  Response refused = execute(call, SendStill(), [&](const CommandResult&) {
    permitted = true;
    return Response();
  });
  auto permit = permitted ? archive_sender_.admit() : nullptr;
  if (permitted && permit == nullptr) {
    constexpr auto kReason = "the last objects are still being written, expected a later request";
    dependencies_.state.counters.archive_refusals.add();
    dependencies_.audit.note(principal, {.what = "archive", .result = std::string("refused: ") + kReason},
                             nullptr);
    refused = refusal(Problem::kUnavailable, kReason);
  }
  if (permit == nullptr) return {.permit = nullptr, .refusal = std::move(refused)};
  return {.permit = std::move(permit)};
}

}  // namespace fanlight
