// SPDX-License-Identifier: Apache-2.0
#include "server/api/operations.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "server/command/command_rules.hpp"

namespace fanlight {

namespace http = boost::beast::http;

namespace {

using enum Problem;
using http::status;
using http::verb;

constexpr std::string_view kJson = "application/json";

constexpr QueryParameter kSize = {
    "size",
    "WIDTHxHEIGHT that the picture fits into, 16 to 2048 each. The proportions stay, and it is never "
    "enlarged. Without it: the usual size.",
    R"({"type": "string", "pattern": "^[0-9]{2,4}x[0-9]{2,4}$", "example": "320x320"})"};
constexpr QueryParameter kQuality = {"quality", "Of the JPEG. Without it: as the server was started.",
                                     R"({"type": "integer", "minimum": 1, "maximum": 100})"};
constexpr QueryParameter kRate = {"rate", "Most pictures a second. Without it: every picture.",
                                  R"({"type": "number", "exclusiveMinimum": 0, "maximum": 1000})"};
constexpr QueryParameter kTime = {
    "t", "Ignored. A new value makes a browser load the picture again into the same element.",
    R"({"type": "string"})"};

constexpr QueryParameter kRevision = {"revision",
                                      "Wait, five seconds at most, for a picture that shows this revision of "
                                      "the scene, as PATCH /api/scene has "
                                      "answered it, or a later one.",
                                      R"({"type": "integer", "minimum": 0})"};

constexpr QueryParameter kOfPng[] = {kRevision, kTime};
constexpr QueryParameter kOfJpeg[] = {kSize, kQuality, kRevision, kTime};
constexpr QueryParameter kOfStream[] = {kSize, kQuality, kRate, kTime};

constexpr std::string_view kMarks =
    "Words in a corner of the picture say where it is not live: NOT LIVE, DELAYED, FROZEN, REPLAY or "
    "SIMULATED.";

Role role_for(const ClientCommand& command) {
  return rule_of(command).least_role;
}

ApiOperation read(ApiId id, std::string_view path, std::string_view name, std::string_view summary,
                  std::string_view schema, std::string_view notes = "") {
  return {.id = id,
          .method = verb::get,
          .path = path,
          .name = name,
          .summary = summary,
          .notes = notes,
          .least_role = Role::kViewer,
          .query = {},
          .request_schema = "",
          .example = "",
          .success = status::ok,
          .media_type = kJson,
          .response_schema = schema,
          .problems = {},
          .takes_control_key = false};
}

ApiOperation picture(ApiId id, std::string_view path, std::string_view name, std::string_view summary,
                     std::string_view media_type, std::string_view notes) {
  ApiOperation operation = read(id, path, name, summary, "", notes);
  operation.media_type = media_type;
  operation.problems = {kFailed, kUnavailable};
  return operation;
}

struct Body {
  std::string_view schema;
  std::string_view example;
};
struct Success {
  http::status status;
  std::string_view schema;
};

ApiOperation change(ApiId id, verb method, std::string_view path, std::string_view name,
                    std::string_view summary, const ClientCommand& command, const Body& body,
                    const Success& success, std::vector<Problem> problems, std::string_view notes = "") {
  ApiOperation operation = read(id, path, name, summary, success.schema, notes);
  operation.method = method;
  operation.least_role = role_for(command);
  operation.request_schema = body.schema;
  operation.example = body.example;
  operation.success = success.status;
  operation.problems = std::move(problems);
  operation.problems.insert(operation.problems.end(), {kTooLarge, kMediaType, kUnavailable});
  operation.takes_control_key = rule_of(command).control != ControlRule::kNone;
  if (operation.takes_control_key)
    operation.problems.insert(operation.problems.end(), {kControlHeld, kControlLapsed});
  return operation;
}

std::vector<ApiOperation> make_operations() {
  std::vector<ApiOperation> all = {
      read(ApiId::kList, "/api", "listOperations", "List the operations of this API", "Operations"),
      read(ApiId::kDescribe, "/api/openapi.json", "describeApi", "Describe this API as OpenAPI 3.1",
           "OpenApi"),
      read(ApiId::kListFields, "/api/fields", "listFields",
           "List the fields of the scene with their units and ranges", "Fields"),
      read(ApiId::kReadScene, "/api/scene", "readScene", "Read the scene in force", "SceneState",
           "The scene of the main view: camera, rays, detector, filter, lights, material and colours."),
      change(ApiId::kChangeScene, verb::patch, "/api/scene", "changeScene", "Change fields of the scene",
             ChangeScene(), {"Scene", R"({"light": {"up_mm": 20}, "mode": "volume"})"},
             {status::ok, "SceneState"}, {kValueNotAllowed},
             "All fields of the body are changed, or none. The next picture shows them: see the parameter "
             "revision of "
             "/api/picture.jpg. Without a control key the change does not acquire control."),
      picture(ApiId::kReadPicturePng, "/api/picture.png", "readPicturePng",
              "Read the newest picture of the main view as PNG", "image/png",
              "In the size in which it was rendered, and without words in it."),
      picture(ApiId::kReadPictureJpeg, "/api/picture.jpg", "readPictureJpeg",
              "Read the newest picture of the main view as JPEG", "image/jpeg", kMarks),
      picture(ApiId::kStreamPictures, "/api/stream.mjpeg", "streamPictures",
              "Stream the pictures of the main view as Motion JPEG",
              "multipart/x-mixed-replace; boundary=fanlight-picture", kMarks),
      picture(ApiId::kReadSurfacePage, "/api/surface.html", "readSurfacePage",
              "Read the surface as a page that needs no server", "text/html; charset=utf-8",
              "The page shows the surface of the newest picture, to be turned, lit and measured offline."),
      read(ApiId::kReadPresets, "/api/presets", "readPresets", "List the saved presets", "Presets"),
      change(ApiId::kChangePresets, verb::post, "/api/presets", "changePresets", "Save or remove a preset",
             ChangePresets(), {"PresetChange", R"({"save": "my face"})"}, {status::ok, "Presets"},
             {kNotFound, kNotPossibleNow, kValueNotAllowed},
             "Without \"scene\" the scene in force is saved. What an admin has saved, only an admin replaces "
             "or removes."),
      read(ApiId::kReadMeasurements, "/api/measurements", "readMeasurements", "List the kept measurements",
           "Measurements"),
      change(ApiId::kChangeMeasurements, verb::post, "/api/measurements", "changeMeasurements",
             "Add, rename or remove measurements", ChangeMeasurements(),
             {"MeasurementChange", R"({"remove_all": true})"}, {status::ok, "MeasurementChanged"},
             {kNotFound, kNotPossibleNow}),
      read(ApiId::kReadControl, "/api/control", "readControl", "Read who is in control", "Control",
           "With a control key also whether control is with it. Such a read keeps the key valid."),
      change(
          ApiId::kChangeControl, verb::post, "/api/control", "changeControl",
          "Ask for control, take it over, keep it, pass it on or release it", ChangeControl(),
          {"ControlChange", R"({"wish": "ask", "name": "my script"})"}, {status::ok, "Control"},
          {kNotPossibleNow, kControlLapsed},
          "The first wish is \"ask\" or, for an admin, \"take_over\". Its answer has a key, which later "
          "requests show in the header Fanlight-Control. Control and key lapse after lapses_after_s without "
          "such a request. \"release\" ends both."),
      read(ApiId::kReadRecording, "/api/recording", "readRecording", "Read the state of the recorder",
           "Recording"),
      change(ApiId::kChangeRecording, verb::post, "/api/recording", "changeRecording",
             "Start or stop a recording, or keep the last seconds", ControlRecorder(),
             {"RecordingWish", R"({"wish": "start"})"}, {status::ok, "RecordingFile"}, {kNotPossibleNow}),
      read(ApiId::kReadReplay, "/api/replay", "readReplay", "Read the state of the played recording",
           "Replay"),
      change(ApiId::kChangeReplay, verb::post, "/api/replay", "changeReplay", "Play, pause, step or seek",
             ControlReplay(), {"ReplayWish", R"({"wish": "pause"})"}, {status::accepted, "Taken"},
             {kNotPossibleNow}, "GET /api/replay shows the effect."),
      read(ApiId::kReadCine, "/api/cine", "readCine", "Read which of the last volumes is on show", "Cine"),
      change(ApiId::kChangeCine, verb::post, "/api/cine", "changeCine",
             "Freeze, show the live picture, or go through the last volumes", ControlCine(),
             {"CineWish", R"({"wish": "freeze"})"}, {status::accepted, "Taken"}, {kNotPossibleNow},
             "GET /api/cine shows the effect."),
      read(ApiId::kReadRtp, "/api/rtp", "readRtp", "Read whether pictures are sent to the RTP receiver",
           "Rtp", "For an admin with the SDP, which may hold the key of the stream."),
      change(ApiId::kChangeRtp, verb::post, "/api/rtp", "changeRtp",
             "Start or stop the pictures to the RTP receiver", ControlRelay(),
             {"RtpWish", R"({"wish": "start"})"}, {status::ok, "Rtp"}, {kNotPossibleNow}),
      read(ApiId::kReadArchive, "/api/archive", "readArchive", "Read how many objects wait for the archive",
           "Archive"),
      change(ApiId::kSendToArchive, verb::post, "/api/archive", "sendToArchive",
             "Put a still, a clip or the volume on show into the queue for the archive", SendStill(),
             {"ArchiveObject", R"({"volume": "shown", "patient": {"patient_id": "42"}})"},
             {status::accepted, "Taken"}, {kNotPossibleNow}, "Up to 16 MiB. 202: it is on the disk."),
  };
  const auto of = [&](ApiId id) -> ApiOperation& { return all.at(static_cast<std::size_t>(id)); };
  of(ApiId::kReadPicturePng).query = kOfPng;
  of(ApiId::kReadPictureJpeg).query = kOfJpeg;
  of(ApiId::kStreamPictures).query = kOfStream;
  of(ApiId::kReadSurfacePage).least_role = kShares;
  of(ApiId::kReadSurfacePage).problems.push_back(kNotPossibleNow);
  of(ApiId::kReadControl).takes_control_key = true;
  of(ApiId::kReadControl).problems.push_back(kControlLapsed);
  of(ApiId::kChangeControl).takes_control_key = true;
  return all;
}

}  // namespace

std::span<const ApiOperation> api_operations() {
  static const std::vector<ApiOperation> operations = make_operations();
  return operations;
}

bool is_api(std::string_view path) {
  return path == "/api" || path.starts_with("/api/");
}

const ApiOperation* find_operation(verb method, std::string_view path) {
  if (method == verb::head) method = verb::get;
  for (const ApiOperation& each : api_operations())
    if (each.path == path && each.method == method) return &each;
  return nullptr;
}

std::string allowed_methods(std::string_view path) {
  std::vector<std::string_view> methods;
  for (const ApiOperation& each : api_operations()) {
    if (each.path != path) continue;
    methods.push_back(http::to_string(each.method));
    if (each.method == verb::get) methods.emplace_back("HEAD");
  }
  return fmt::format("{}", fmt::join(methods, ", "));
}

}  // namespace fanlight
