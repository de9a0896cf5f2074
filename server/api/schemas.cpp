// SPDX-License-Identifier: Apache-2.0
#include "server/api/schemas.hpp"

#include <fmt/format.h>
#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <cctype>
#include <string>
#include <string_view>

#include "proto/fanlight.pb.h"
#include "server/access/session_identity.hpp"
#include "server/api/problem.hpp"
#include "server/state/scene_json.hpp"

namespace fanlight {

namespace {

using nlohmann::ordered_json;
using Field = google::protobuf::FieldDescriptor;

/// How a message is written: as message_json() does, or as protobuf does (proto3 JSON, names preserved).
enum class Form : std::uint8_t { kPlain, kProtobuf };

ordered_json message_schema(const google::protobuf::Descriptor& descriptor, Form form);

ordered_json choices_schema(const google::protobuf::EnumDescriptor& choices, Form form) {
  ordered_json names = ordered_json::array();
  for (int index = 0; index < choices.value_count(); ++index) {
    std::string name(choices.value(index)->name());
    if (form == Form::kPlain)
      std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
    names.push_back(name);
  }
  return {{"type", "string"}, {"enum", names}};
}

/// 64 bits do not fit into the numbers of JavaScript: protobuf writes them as texts.
ordered_json large_schema(Form form, bool is_signed) {
  if (form == Form::kPlain) return {{"type", "integer"}, {"minimum", 0}};
  return {{"type", "string"}, {"pattern", is_signed ? "^-?[0-9]+$" : "^[0-9]+$"}};
}

ordered_json value_schema(const Field& field, Form form) {
  switch (field.cpp_type()) {
    case Field::CPPTYPE_BOOL:
      return {{"type", "boolean"}};
    case Field::CPPTYPE_FLOAT:
    case Field::CPPTYPE_DOUBLE:
      return {{"type", "number"}};
    case Field::CPPTYPE_INT32:
      return {{"type", "integer"}};
    case Field::CPPTYPE_UINT32:
      return {{"type", "integer"}, {"minimum", 0}};
    case Field::CPPTYPE_INT64:
      return large_schema(form, true);
    case Field::CPPTYPE_UINT64:
      return large_schema(form, false);
    case Field::CPPTYPE_ENUM:
      return choices_schema(*field.enum_type(), form);
    case Field::CPPTYPE_STRING:
      if (field.type() == Field::TYPE_BYTES) return {{"type", "string"}, {"contentEncoding", "base64"}};
      return {{"type", "string"}};
    case Field::CPPTYPE_MESSAGE:
      return message_schema(*field.message_type(), form);
  }
  return ordered_json::object();
}

ordered_json message_schema(const google::protobuf::Descriptor& descriptor, Form form) {
  ordered_json properties = ordered_json::object();
  for (int index = 0; index < descriptor.field_count(); ++index) {
    const Field& field = *descriptor.field(index);
    ordered_json value = value_schema(field, form);
    if (field.is_repeated()) value = {{"type", "array"}, {"items", value}};
    properties[std::string(field.name())] = value;
  }
  return {{"type", "object"}, {"properties", properties}};
}

template <typename Message>
ordered_json schema_of(Form form = Form::kPlain) {
  return message_schema(*Message::descriptor(), form);
}

bool is_whole(const SceneField& field) {
  return field.step >= 1 && field.step == static_cast<double>(static_cast<int>(field.step));
}

ordered_json number(double value) {
  const auto whole = static_cast<std::int64_t>(value);
  return static_cast<double>(whole) == value ? ordered_json(whole) : ordered_json(value);
}

ordered_json field_schema(const SceneField& field) {
  ordered_json schema;
  if (field.is_text()) {
    schema["type"] = "string";
  } else if (!field.choices.empty()) {
    schema["type"] = "string";
    schema["enum"] = field.choices;
  } else {
    schema["type"] = is_whole(field) ? "integer" : "number";
    schema["minimum"] = number(field.minimum);
    schema["maximum"] = number(field.maximum);
  }
  schema["description"] =
      field.unit.empty() ? std::string(field.help) : fmt::format("{}, {}", field.help, field.unit);
  return schema;
}

ordered_json closed_object() {
  return {{"type", "object"}, {"properties", ordered_json::object()}, {"additionalProperties", false}};
}

/// The groups of the scene with their fields; a body may have some of them.
ordered_json scene_schema() {
  ordered_json scene = closed_object();
  scene["description"] = "Fields of the scene. GET /api/fields has them as a list.";
  for (const SceneField& field : scene_fields()) {
    const std::size_t dot = field.name.find('.');
    ordered_json* object = &scene["properties"];
    if (dot != std::string_view::npos) {
      ordered_json& group = (*object)[std::string(field.name.substr(0, dot))];
      if (group.is_null()) group = closed_object();
      object = &group["properties"];
    }
    (*object)[std::string(field.name.substr(dot == std::string_view::npos ? 0 : dot + 1))] =
        field_schema(field);
  }
  return scene;
}

ordered_json problem_schema() {
  ordered_json urns = ordered_json::array();
  for (const ProblemType& each : problem_types()) urns.push_back(problem_urn(each.problem));
  ordered_json schema = ordered_json::parse(R"json({
    "type": "object",
    "description": "Problem details (RFC 9457).",
    "required": ["type", "title", "status", "detail"],
    "properties": {
      "type": {"type": "string"},
      "title": {"type": "string"},
      "status": {"type": "integer"},
      "detail": {"type": "string", "description": "One sentence: what is wrong, and what was expected."},
      "field": {"type": "string", "description": "The field of the scene that was refused."},
      "minimum": {"type": "number"},
      "maximum": {"type": "number"},
      "choices": {"type": "array", "items": {"type": "string"}}
    }
  })json");
  schema["properties"]["type"]["enum"] = urns;
  return schema;
}

/// A body {"wish": WORD}: one of `words`, or a word with a number, as `pattern` has it.
ordered_json wish_schema(std::string_view pattern, std::string_view help) {
  return {{"type", "object"},
          {"required", {"wish"}},
          {"additionalProperties", false},
          {"properties", {{"wish", {{"type", "string"}, {"pattern", pattern}, {"description", help}}}}}};
}

ordered_json control_change_schema() {
  ordered_json schema = wish_schema("^(ask|take_over|keep|release|grant=[0-9]+)$",
                                    "ask: acquire control if it is free, else wait for it. take_over: "
                                    "acquire it from another client, for an "
                                    "admin. keep: renew it without a change. release: give it up, or stop "
                                    "waiting. grant=SESSION: pass it to "
                                    "one of those who ask.");
  schema["properties"]["name"] = {
      {"type", "string"},
      {"maxLength", kLongestNameBytes},
      {"description", "Shown to the others; with the first wish. Without it: the token's name."}};
  return schema;
}

ordered_json measurement_change_schema() {
  const ordered_json id = {{"type", {"string", "integer"}}, {"pattern", "^[0-9]+$"}};
  ordered_json schema = closed_object();
  schema["minProperties"] = 1;
  schema["maxProperties"] = 1;
  ordered_json name = closed_object();
  name["required"] = {"id", "name"};
  name["properties"] = {{"id", id}, {"name", {{"type", "string"}}}};
  schema["properties"] = {{"add", {{"$ref", "#/components/schemas/Measurement"}}},
                          {"rename", name},
                          {"remove", id},
                          {"remove_all", {{"const", true}}}};
  return schema;
}

/// Bodies that no table has.
ordered_json written_schemas() {
  return ordered_json::parse(R"json({
    "OpenApi": {"type": "object", "required": ["openapi", "info", "paths"]},
    "Operations": {
      "type": "object", "required": ["version", "description", "stream", "operations"],
      "properties": {
        "version": {"type": "string", "description": "Of the program."},
        "description": {"const": "/api/openapi.json"},
        "stream": {
          "type": "object", "required": ["address", "protocol", "package"],
          "description": "The WebSocket of the displays.",
          "properties": {"address": {"const": "/stream"},
                         "protocol": {"type": "string", "description": "The WebSocket subprotocol."},
                         "package": {"type": "string", "description": "Of the messages in proto/fanlight.proto."}}},
        "operations": {"type": "array", "items": {
          "type": "object", "required": ["method", "path", "summary", "least_role"],
          "properties": {"method": {"type": "string"}, "path": {"type": "string"}, "summary": {"type": "string"},
                         "least_role": {"enum": ["viewer", "operator", "admin"]}}}}}},
    "Fields": {
      "type": "object", "required": ["fields"],
      "properties": {"fields": {"type": "array", "items": {
        "type": "object", "required": ["name", "type", "help"],
        "properties": {
          "name": {"type": "string", "description": "GROUP.FIELD, as in the scene and on the command line."},
          "type": {"enum": ["number", "integer", "choice", "text"]},
          "unit": {"type": "string"}, "help": {"type": "string"},
          "minimum": {"type": "number"}, "maximum": {"type": "number"},
          "step": {"type": "number", "description": "The value is the minimum and a whole number of steps."},
          "choices": {"type": "array", "items": {"type": "string"}}}}}}},
    "SceneState": {
      "type": "object", "required": ["revision", "scene"],
      "properties": {"revision": {"type": "integer", "minimum": 0, "description": "Grows with each change."},
                     "scene": {"$ref": "#/components/schemas/Scene"}}},
    "Presets": {
      "type": "object", "required": ["presets"],
      "properties": {"presets": {"type": "array", "items": {
        "type": "object", "required": ["name", "saved_by", "admin", "scene"],
        "properties": {"name": {"type": "string"}, "saved_by": {"type": "string"},
                       "admin": {"type": "boolean", "description": "An admin has saved it."},
                       "scene": {"$ref": "#/components/schemas/Scene"}}}}}},
    "PresetChange": {
      "oneOf": [
        {"type": "object", "required": ["save"], "additionalProperties": false,
         "properties": {"save": {"type": "string", "description": "Its name."},
                        "scene": {"$ref": "#/components/schemas/Scene"},
                        "with_cuts": {"type": "boolean", "description": "With the cuts of the scalpel."}}},
        {"type": "object", "required": ["remove"], "additionalProperties": false,
         "properties": {"remove": {"type": "string", "description": "Its name."}}}]},
    "MeasurementChanged": {
      "type": "object", "required": ["done"],
      "properties": {"done": {"const": true},
                     "id": {"type": "string", "pattern": "^[0-9]+$", "description": "Of what was added or renamed."}}},
    "Control": {
      "type": "object", "required": ["holder", "asking", "lapses_after_s", "mine", "waiting"],
      "properties": {
        "holder": {"oneOf": [{"type": "null"}, {"$ref": "#/components/schemas/Session"}],
                   "description": "null: control is free."},
        "asking": {"type": "array", "items": {"$ref": "#/components/schemas/Session"},
                   "description": "Those who wait for it, the first one first."},
        "lapses_after_s": {"type": "number"},
        "mine": {"type": "boolean", "description": "It is with the control key that was shown."},
        "waiting": {"type": "boolean", "description": "The control key waits for it."},
        "session": {"type": "integer", "description": "Of the control key."},
        "key": {"type": "string", "description": "Of the first wish: show it in the header Fanlight-Control."}}},
    "Session": {
      "type": "object", "required": ["session", "name"],
      "properties": {"session": {"type": "integer", "minimum": 1}, "name": {"type": "string"}}},
    "RecordingFile": {
      "type": "object", "required": ["file"],
      "properties": {"file": {"type": "string", "description": "In the server's folder of recordings."}}},
    "Taken": {
      "type": "object", "required": ["taken"],
      "properties": {"taken": {"type": ["string", "boolean"], "description": "The wish as it was understood."}}},
    "Rtp": {
      "type": "object", "required": ["state"],
      "properties": {
        "state": {"enum": ["no_receiver", "sending", "stopped"]},
        "to": {"type": "string"}, "encrypted": {"type": "boolean"},
        "receiver": {"type": "object", "properties": {
          "lost_percent": {"type": "number"}, "lost_packets": {"type": "integer"}, "jitter_ms": {"type": "number"}}},
        "sdp": {"type": "string"}}},
    "Archive": {
      "type": "object", "required": ["available"],
      "properties": {"available": {"type": "boolean"},
                     "waiting": {"type": "integer", "minimum": 0},
                     "refused": {"type": "integer", "minimum": 0, "description": "By the archive, for good."}}},
    "Patient": {
      "type": "object", "additionalProperties": false,
      "description": "As `fanlight worklist` saves it. A name or an ID is required.",
      "properties": {
        "patient_name": {"type": "string"}, "patient_id": {"type": "string"},
        "issuer_of_patient_id": {"type": "string"}, "birth_date": {"type": "string", "pattern": "^[0-9]{8}$"},
        "sex": {"enum": ["M", "F", "O"]}, "accession_number": {"type": "string"}, "study_uid": {"type": "string"},
        "study_id": {"type": "string"}, "study_description": {"type": "string"},
        "referring_physician": {"type": "string"}, "requested_procedure_id": {"type": "string"},
        "scheduled_step_id": {"type": "string"}}},
    "ArchiveObject": {
      "oneOf": [
        {"type": "object", "required": ["png", "patient"], "additionalProperties": false,
         "properties": {"png": {"type": "string", "contentEncoding": "base64"},
                        "patient": {"$ref": "#/components/schemas/Patient"},
                        "lossy": {"type": "object", "required": ["method", "ratio"], "additionalProperties": false,
                                  "description": "How the picture was compressed before.",
                                  "properties": {"method": {"enum": ["jpeg", "h264"]},
                                                 "ratio": {"type": "number", "minimum": 1, "maximum": 100000}}}}},
        {"type": "object", "required": ["jpegs", "pictures_per_second", "patient"], "additionalProperties": false,
         "properties": {"jpegs": {"type": "array", "items": {"type": "string", "contentEncoding": "base64"}},
                        "pictures_per_second": {"type": "number", "minimum": 0.1, "maximum": 60},
                        "patient": {"$ref": "#/components/schemas/Patient"}}},
        {"type": "object", "required": ["volume", "patient"], "additionalProperties": false,
         "properties": {"volume": {"oneOf": [{"const": "shown"}, {"type": "integer", "minimum": 0}],
                                   "description": "\"shown\", or the volume_id that must be on show."},
                        "patient": {"$ref": "#/components/schemas/Patient"}}}]}
  })json");
}

}  // namespace

ordered_json api_schemas() {
  ordered_json schemas = written_schemas();
  schemas["Problem"] = problem_schema();
  schemas["Scene"] = scene_schema();
  schemas["Measurement"] = schema_of<v1::Measurement>(Form::kProtobuf);
  schemas["Measurements"] = {
      {"type", "object"},
      {"required", {"measurements", "with_recording", "trouble"}},
      {"properties",
       {{"measurements", {{"type", "array"}, {"items", {{"$ref", "#/components/schemas/Measurement"}}}}},
        {"with_recording", {{"type", "boolean"}, {"description", "They are kept beside the recording."}}},
        {"trouble", {{"type", "string"}, {"description", "Why they are not saved; else empty."}}}}}};
  schemas["MeasurementChange"] = measurement_change_schema();
  schemas["ControlChange"] = control_change_schema();
  schemas["Recording"] = schema_of<v1::RecordingStatus>();
  schemas["Recording"]["required"] = {"available"};
  schemas["RecordingWish"] = wish_schema(
      "^(start|stop|keep)$", "start, stop, or keep: write the last seconds, where the server holds them.");
  schemas["Replay"] = schema_of<v1::ReplayStatus>();
  schemas["Replay"]["required"] = {"state"};
  schemas["Replay"]["properties"]["ending"] = {{"enum", {"once", "loop", "to-and-fro"}}};
  schemas["ReplayWish"] = wish_schema(
      "^(play|pause|step(=.+)?|seek=.+|frame=.+|speed=.+|ending=(once|loop|to-and-fro))$",
      "play, pause, step or step=-2 (sweeps), seek=3.5 (seconds), frame=120 (its number), speed=0.5, or what "
      "follows the last frame: ending=once, ending=loop, ending=to-and-fro.");
  schemas["Cine"] = schema_of<v1::CineStatus>();
  schemas["Cine"]["required"] = {"state"};
  schemas["CineWish"] = wish_schema(
      "^(freeze|live|play|pause|step(=.+)?|seek=.+|speed=.+)$",
      "freeze, live, play, pause, step or step=-2 (volumes), seek=3 (a volume, from 0), speed=0.5.");
  schemas["RtpWish"] = wish_schema("^(start|stop)$", "start or stop.");
  return schemas;
}

ordered_json field_json(const SceneField& field) {
  const bool is_number = !field.is_text() && field.choices.empty();
  ordered_json json = {{"name", field.name}};
  json["type"] = field.is_text() ? "text" : !is_number ? "choice" : is_whole(field) ? "integer" : "number";
  if (!field.unit.empty()) json["unit"] = field.unit;
  json["help"] = field.help;
  if (is_number) {
    json["minimum"] = number(field.minimum);
    json["maximum"] = number(field.maximum);
    if (field.step > 0) json["step"] = number(field.step);
  } else if (!field.is_text()) {
    json["choices"] = field.choices;
  }
  return json;
}

}  // namespace fanlight
