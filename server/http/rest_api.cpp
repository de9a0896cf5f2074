// SPDX-License-Identifier: Apache-2.0
#include "server/http/rest_api.hpp"

#include <fmt/format.h>

#include <array>
#include <nlohmann/json.hpp>

#include "proto/base/printable.hpp"
#include "server/http/api_response.hpp"
#include "server/state/scene_json.hpp"
#include "server/state/scene_message.hpp"
#include "server/stream/preset_author.hpp"

namespace fanlight {

namespace http = boost::beast::http;

namespace {

using nlohmann::json;
using nlohmann::ordered_json;

RestApi::Response no_picture() {
  RestApi::Response response =
      refusal(http::status::service_unavailable, "there is no picture yet, expected some patience");
  response.set(http::field::retry_after, "1");
  return response;
}

ordered_json recording_json(const v1::RecordingStatus& status) {
  if (!status.available()) return {{"available", false}};
  constexpr std::array<std::string_view, 4> kStates = {"idle", "recording", "no_room", "finishing"};
  return {{"available", true},
          {"state", kStates.at(status.state())},
          {"ring", status.ring()},
          {"keeps_last_s", status.keeps_last_s()},
          {"file", status.file()},
          {"frames", status.frames()},
          {"bytes", status.bytes()},
          {"duration_s", status.duration_s()},
          {"frames_missed", status.frames_missed()},
          {"finish_share", status.finish_share()},
          {"trouble", status.trouble()},
          {"last_file", status.last_file()},
          {"last_frames", status.last_frames()},
          {"last_duration_s", status.last_duration_s()},
          {"last_trouble", status.last_trouble()}};
}

ordered_json replay_json(const v1::ReplayStatus& status) {
  constexpr std::array<std::string_view, 5> kStates = {"no_recording", "playing", "paused", "ended",
                                                       "failed"};
  constexpr std::array<std::string_view, 3> kEndings = {"once", "loop", "to-and-fro"};
  ordered_json told = {{"state", kStates.at(status.state())}};
  if (status.state() == v1::ReplayStatus::NO_RECORDING) return told;
  told.update({{"time_s", status.time_s()},
               {"duration_s", status.duration_s()},
               {"sweep", status.sweep()},
               {"sweeps", status.sweeps()},
               {"speed", status.speed()},
               {"ending", kEndings.at(status.ending())},
               {"backward", status.backward()},
               {"trouble", status.trouble()}});
  return told;
}

ordered_json cine_json(const v1::CineStatus& status) {
  constexpr std::array<std::string_view, 3> kStates = {"live", "frozen", "playing"};
  return {{"state", kStates.at(status.state())},
          {"capacity", status.capacity()},
          {"volumes", status.volumes()},
          {"volume", status.volume()},
          {"time_s", status.time_s()},
          {"duration_s", status.duration_s()},
          {"speed", status.speed()}};
}

ordered_json state_json(const NumberedScene& scene) {
  return {{"revision", scene.revision}, {"scene", scene_json(scene.scene)}};
}

}  // namespace

RestApi::Response RestApi::respond(const Request& request, std::string_view path,
                                   const Principal& principal) {
  const bool reads = request.method() == http::verb::get || request.method() == http::verb::head;
  if (path == "/api/scene" && reads) return scene();
  if (path == "/api/scene" && request.method() == http::verb::patch) return change_scene(request, principal);
  if (path == "/api/recording" && reads) return recording();
  if (path == "/api/recording" && request.method() == http::verb::post) return record(request, principal);
  if (path == "/api/replay" && reads) return replay();
  if (path == "/api/replay" && request.method() == http::verb::post)
    return control_replay(request, principal);
  if (path == "/api/cine" && reads) return cine();
  if (path == "/api/cine" && request.method() == http::verb::post) return control_cine(request, principal);
  if (path == "/api/presets" && reads) return presets();
  if (path == "/api/presets" && request.method() == http::verb::post)
    return change_presets(request, principal);
  if (path == "/api/rtp") return dependencies_.rtp.respond(request, principal);
  if (path == "/api/scene") return wrong_method("GET or PATCH", "GET, HEAD, PATCH");
  if (path == "/api/picture.png") return wrong_method("GET", "GET, HEAD");
  if (path == "/api/recording" || path == "/api/replay" || path == "/api/cine" || path == "/api/presets")
    return wrong_method("GET or POST", "GET, HEAD, POST");
  return refusal(
      http::status::not_found,
      "there is nothing here, expected /api/scene, /api/picture.png, /api/presets, /api/recording, "
      "/api/replay, /api/cine or /api/rtp");
}

RestApi::Response RestApi::scene() const {
  return json_response(http::status::ok, state_json(dependencies_.scene_store.in_force()));
}

RestApi::Response RestApi::recording() const {
  return json_response(http::status::ok, recording_json(dependencies_.recording.message()));
}

RestApi::Response RestApi::record(const Request& request, const Principal& principal) {
  if (!is_json(request)) return expected_json();
  const auto parsed = json::parse(request.body(), nullptr, false);
  const auto word = parsed.is_object() ? parsed.value("wish", json()) : json();
  const auto wish = word.is_string() ? recording_wish(word.get<std::string>()) : std::nullopt;
  if (!wish) {
    dependencies_.counters.recording_refusals.add();
    return refusal(http::status::bad_request,
                   R"(the wish is not known, expected {"wish": "start"}, "stop" or "keep")");
  }
  const auto may = dependencies_.control.may_change({.session = 0, .name = principal.name}, principal.role);
  const auto file = may ? dependencies_.recording.request(*wish) : Result<std::string>(may.error());
  json details = {{"wish", recording_word(*wish)}};
  if (!file) {
    dependencies_.counters.recording_refusals.add();
    dependencies_.audit.note(principal, {.what = "recording", .result = "refused: " + file.error().message},
                             details);
    return refusal(principal.role == Role::kViewer ? http::status::forbidden : http::status::conflict,
                   file.error().message);
  }
  details["file"] = *file;
  dependencies_.audit.note(principal, {.what = "recording", .result = "done"}, details);
  return json_response(http::status::ok, {{"file", *file}});
}

RestApi::Response RestApi::replay() const {
  return json_response(http::status::ok, replay_json(dependencies_.replay.message()));
}

template <typename Proxy, typename Wish>
RestApi::Response RestApi::carry_out(const WishKind& kind, const Result<Wish>& wish, Proxy& proxy,
                                     const std::string& words, const Principal& principal) {
  if (!wish) {
    kind.refusals.add();
    return refusal(http::status::bad_request, wish.error().message);
  }
  const auto may = dependencies_.control.may_change({.session = 0, .name = principal.name}, principal.role);
  const Result<void> done = may ? proxy.request(*wish) : Result<void>(may.error());
  dependencies_.audit.note(principal,
                           {.what = kind.name, .result = done ? "done" : "refused: " + done.error().message},
                           {{"wish", words}});
  if (done) return json_response(http::status::ok, {{"taken", words}});
  kind.refusals.add();
  const bool bad = may && done.error().code == ErrorCode::kInvalidArgument;
  return refusal(principal.role == Role::kViewer ? http::status::forbidden
                 : bad                           ? http::status::bad_request
                                                 : http::status::conflict,
                 done.error().message);
}

RestApi::Response RestApi::control_replay(const Request& request, const Principal& principal) {
  if (!is_json(request)) return expected_json();
  const auto wish = replay_request(wish_text(request));
  return carry_out({.name = "replay", .refusals = dependencies_.counters.replay_refusals}, wish,
                   dependencies_.replay, wish ? replay_words(*wish) : "", principal);
}

RestApi::Response RestApi::presets() const {
  RestApi::Response response(http::status::ok, 11);
  response.set(http::field::content_type, "application/json");
  response.body() = dependencies_.presets.json();
  return response;
}

RestApi::Response RestApi::change_presets(const Request& request, const Principal& principal) {
  if (!is_json(request)) return expected_json();
  const auto refused = [&](http::status status, const std::string& sentence, const json& details) {
    dependencies_.counters.preset_refusals.add();
    dependencies_.audit.note(principal, {.what = "preset", .result = "refused: " + sentence}, details);
    return refusal(status, sentence);
  };
  if (principal.role == Role::kViewer)
    return refused(http::status::forbidden, "a viewer saves no presets, expected the role of an operator",
                   {});
  const auto parsed = json::parse(request.body(), nullptr, false);
  const auto text_of = [&](const char* key) {
    const auto value = parsed.is_object() ? parsed.value(key, json()) : json();
    return value.is_string() ? value.get<std::string>() : std::string();
  };
  v1::PresetRequest wish;
  const bool removes = parsed.is_object() && parsed.contains("remove");
  if (!parsed.is_object() || parsed.contains("save") == removes)
    return refused(http::status::bad_request, R"(expected {"save": NAME} or {"remove": NAME})", {});
  if (removes) {
    wish.set_remove(text_of("remove"));
  } else {
    wish.mutable_save()->set_name(text_of("save"));
  }
  const std::string name = printable(removes ? wish.remove() : wish.save().name());
  const json details = {{removes ? "remove" : "save", name}};
  if (!removes && parsed.contains("scene")) {
    auto scene = scene_change_from_json(parsed["scene"]);
    if (!scene) return refused(http::status::bad_request, scene.error().message, details);
    *wish.mutable_save()->mutable_scene() = *std::move(scene);
  }
  const auto done = dependencies_.presets.request(
      wish, scene_message(dependencies_.scene_store.in_force().scene), preset_author(principal));
  if (!done) {
    const ErrorCode code = done.error().code;
    return refused(code == ErrorCode::kNotFound          ? http::status::not_found
                   : code == ErrorCode::kInvalidArgument ? http::status::bad_request
                                                         : http::status::conflict,
                   done.error().message, details);
  }
  dependencies_.audit.note(principal, {.what = "preset", .result = "done"}, details);
  return presets();
}

RestApi::Response RestApi::cine() const {
  return json_response(http::status::ok, cine_json(dependencies_.cine.message()));
}

RestApi::Response RestApi::control_cine(const Request& request, const Principal& principal) {
  if (!is_json(request)) return expected_json();
  const auto wish = cine_request(wish_text(request));
  return carry_out({.name = "cine", .refusals = dependencies_.counters.cine_refusals}, wish,
                   dependencies_.cine, wish ? cine_words(*wish) : "", principal);
}

void RestApi::audit_change(const Principal& principal, const std::string& result, const json& details) const {
  dependencies_.audit.note(principal, {.what = "scene_change", .result = result}, details);
}

RestApi::Response RestApi::change_scene(const Request& request, const Principal& principal) {
  if (!is_json(request)) return expected_json();
  if (const auto may =
          dependencies_.control.may_change({.session = 0, .name = principal.name}, principal.role);
      !may) {
    dependencies_.counters.scene_refusals.add();
    audit_change(principal, "refused: " + may.error().message, nullptr);
    return refusal(principal.role == Role::kViewer ? http::status::forbidden : http::status::conflict,
                   may.error().message);
  }
  const auto parsed = json::parse(request.body(), nullptr, false);
  if (parsed.is_discarded()) {
    dependencies_.counters.scene_refusals.add();
    return refusal(http::status::bad_request,
                   "the body is no JSON, expected an object with fields of the scene");
  }
  const auto change = scene_change_from_json(parsed);
  const SceneField* refused = nullptr;
  const auto applied =
      change ? dependencies_.scene_store.apply(*change, &refused) : Result<bool>(change.error());
  if (!applied) {
    dependencies_.counters.scene_refusals.add();
    if (change) audit_change(principal, "refused: " + applied.error().message, change_json(*change));
    return refusal(http::status::unprocessable_entity, applied.error().message, refused);
  }
  dependencies_.counters.scene_changes.add();
  audit_change(principal, "done", change_json(*change));
  if (*applied) dependencies_.sessions.scene_changed(0);
  return scene();
}

void RestApi::picture(const Principal& principal, const std::function<void(Response)>& answer,
                      std::int64_t now_ns) {
  dependencies_.demand.asked(now_ns);
  if (dependencies_.hub.newest_picture() != nullptr) return encode_picture(principal, answer);
  const bool is_coming = dependencies_.demand.resting() || !waiting_.empty();
  if (!is_coming || waiting_.size() >= PictureHub::kMostFileRequests) return answer(no_picture());
  waiting_.push_back({principal, answer, now_ns + kMostWaitNs});
}

void RestApi::answer_waiting(std::int64_t now_ns) {
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
      encode_picture(each.principal, each.answer);
    } else {
      each.answer(no_picture());
    }
  }
}

void RestApi::encode_picture(const Principal& principal, const std::function<void(Response)>& answer) {
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
