// SPDX-License-Identifier: Apache-2.0
#include "server/api/open_api.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/beast/core/string.hpp>
#include <boost/beast/http/verb.hpp>
#include <map>
#include <string>
#include <vector>

#include "proto/base/version.hpp"
#include "server/api/operations.hpp"
#include "server/api/schemas.hpp"
#include "server/stream/stream_protocol.hpp"

namespace fanlight {

namespace {

namespace http = boost::beast::http;
using nlohmann::ordered_json;

constexpr std::string_view kAbout =
    "Read and change a Fanlight server: the scene, the pictures of its main view, presets, measurements, "
    "recordings and control. Clients without a session are called scripts. A script has the role of its "
    "token "
    "or certificate; a server on loopback without tokens takes every client for an admin. Refusals are "
    "problem "
    "details (RFC 9457). Unknown keys of a body or a query are refused.\n\n"
    "Displays use the WebSocket at /stream (proto/DISPLAY_PROTOCOL.md). Two names have a number there, which "
    "count different things: fanlight.v1 is the protobuf package of the messages, and stays as long as "
    "messages can be read as before; fanlight.v2 is the WebSocket subprotocol, the order and the meaning of "
    "the messages, of which the second version is in force.";

std::string reference(std::string_view schema) {
  return fmt::format("#/components/schemas/{}", schema);
}

ordered_json content(std::string_view media_type, std::string_view schema) {
  ordered_json body = ordered_json::object();
  if (!schema.empty()) body["schema"] = {{"$ref", reference(schema)}};
  return {{std::string(media_type.substr(0, media_type.find(';'))), body}};
}

ordered_json parameters(const ApiOperation& operation) {
  ordered_json list = ordered_json::array();
  for (const QueryParameter& each : operation.query) {
    list.push_back({{"name", each.name},
                    {"in", "query"},
                    {"description", each.help},
                    {"schema", ordered_json::parse(each.schema)}});
  }
  if (operation.takes_control_key) {
    list.push_back({{"name", kControlKeyHeader},
                    {"in", "header"},
                    {"description", "The key that POST /api/control has given."},
                    {"schema", {{"type", "string"}}}});
  }
  return list;
}

ordered_json success(const ApiOperation& operation) {
  ordered_json response = {{"description", "Done"}};
  if (operation.success == http::status::accepted) response["description"] = "Taken; the effect comes later";
  response["content"] = content(operation.media_type, operation.response_schema);
  const bool is_picture = operation.id == ApiId::kReadPicturePng || operation.id == ApiId::kReadPictureJpeg;
  if (!is_picture) return response;
  const ordered_json number = {{"schema", {{"type", "integer"}}}};
  response["headers"] = {
      {"X-Fanlight-Picture-Id", number},
      {"X-Fanlight-Volume-Id", number},
      {"X-Fanlight-Scene-Revision", number},
      {"X-Fanlight-Liveness",
       {{"description", "Whether the picture shows what the source sends now."},
        {"schema", {{"enum", {"waiting", "live", "delayed", "not live", "replay", "frozen", "resting"}}}}}},
      {"X-Fanlight-Origin",
       {{"description", "Where the frames come from."},
        {"schema", {{"enum", {"probe", "unknown", "simulated", "recording"}}}}}}};
  return response;
}

/// The problems of an operation by status; several may have one status.
using ProblemsByStatus = std::map<unsigned, std::vector<const ProblemType*>>;

ProblemsByStatus problems_of(const ApiOperation& operation) {
  ProblemsByStatus by_status;
  const auto add = [&](Problem problem) {
    const ProblemType& type = type_of(problem);
    by_status[static_cast<unsigned>(type.status)].push_back(&type);
  };
  for (const Problem each : kUsualProblems) add(each);
  for (const Problem each : operation.problems) add(each);
  return by_status;
}

/// Name of a response that stands for these problems: "control-held.control-lapsed".
std::string response_name(const std::vector<const ProblemType*>& types) {
  std::string name;
  for (const ProblemType* type : types) name += fmt::format("{}{}", name.empty() ? "" : ".", type->name);
  return name;
}

ordered_json problem_response(const std::vector<const ProblemType*>& types) {
  std::string description;
  for (const ProblemType* type : types)
    description += fmt::format("{}{}: {}", description.empty() ? "" : ". ", type->name, type->title);
  return {{"description", description}, {"content", content("application/problem+json", "Problem")}};
}

ordered_json problem_responses() {
  ordered_json all = ordered_json::object();
  for (const ApiOperation& operation : api_operations())
    for (const auto& [status, types] : problems_of(operation))
      all[response_name(types)] = problem_response(types);
  return all;
}

ordered_json responses(const ApiOperation& operation) {
  ordered_json all;
  all[std::to_string(static_cast<unsigned>(operation.success))] = success(operation);
  for (const auto& [status, types] : problems_of(operation))
    all[std::to_string(status)] = {{"$ref", fmt::format("#/components/responses/{}", response_name(types))}};
  return all;
}

ordered_json operation_json(const ApiOperation& operation) {
  ordered_json described = {{"operationId", operation.name}, {"summary", operation.summary}};
  const std::string role = fmt::format("Least role: {}.", role_name(operation.least_role));
  described["description"] = operation.notes.empty() ? role : fmt::format("{} {}", operation.notes, role);
  described["x-least-role"] = role_name(operation.least_role);
  if (ordered_json list = parameters(operation); !list.empty()) described["parameters"] = list;
  if (!operation.request_schema.empty()) {
    ordered_json body = content("application/json", operation.request_schema);
    body["application/json"]["example"] = ordered_json::parse(operation.example);
    described["requestBody"] = {{"required", true}, {"content", body}};
  }
  described["responses"] = responses(operation);
  return described;
}

}  // namespace

ordered_json open_api() {
  ordered_json paths;
  for (const ApiOperation& each : api_operations()) {
    std::string method(http::to_string(each.method));
    std::ranges::transform(method, method.begin(), [](unsigned char c) { return std::tolower(c); });
    paths[std::string(each.path)][method] = operation_json(each);
  }
  return {{"openapi", "3.1.0"},
          {"info",
           {{"title", "Fanlight"},
            {"version", version()},
            {"summary", "4D-ultrasound rendering service"},
            {"description", kAbout},
            {"license", {{"name", "Apache-2.0"}, {"identifier", "Apache-2.0"}}}}},
          {"servers", {{{"url", "/"}}}},
          {"security", {{{"token", ordered_json::array()}}, ordered_json::object()}},
          {"paths", paths},
          {"components",
           {{"schemas", api_schemas()},
            {"responses", problem_responses()},
            {"securitySchemes",
             {{"token",
               {{"type", "http"},
                {"scheme", "bearer"},
                {"description",
                 "A token of `fanlight token add`. A client certificate does as well. None is needed "
                 "where the server was started without tokens."}}}}}}}};
}

ordered_json operation_list() {
  ordered_json operations = ordered_json::array();
  for (const ApiOperation& each : api_operations()) {
    operations.push_back({{"method", http::to_string(each.method)},
                          {"path", each.path},
                          {"summary", each.summary},
                          {"least_role", role_name(each.least_role)}});
  }
  return {{"version", version()},
          {"description", "/api/openapi.json"},
          {"stream",
           {{"address", "/stream"},
            {"protocol", fmt::format("fanlight.v{}", kProtocolVersion)},
            {"package", "fanlight.v1"}}},
          {"operations", operations}};
}

}  // namespace fanlight
