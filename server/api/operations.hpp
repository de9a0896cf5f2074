// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/beast/http/status.hpp>
#include <boost/beast/http/verb.hpp>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/access/role.hpp"
#include "server/api/problem.hpp"

namespace fanlight {

/// The operations of the REST API. RestApi serves them, and open_api() describes them, by the same table.
enum class ApiId : std::uint8_t {
  kList,
  kDescribe,
  kListFields,
  kReadScene,
  kChangeScene,
  kReadPicturePng,
  kReadPictureJpeg,
  kStreamPictures,
  kReadSurfacePage,
  kReadPresets,
  kChangePresets,
  kReadMeasurements,
  kChangeMeasurements,
  kReadControl,
  kChangeControl,
  kReadRecording,
  kChangeRecording,
  kReadReplay,
  kChangeReplay,
  kReadCine,
  kChangeCine,
  kReadRtp,
  kChangeRtp,
  kReadArchive,
  kSendToArchive,
};

/// A parameter of the query.
struct QueryParameter {
  std::string_view name;
  std::string_view help;
  std::string_view schema;  ///< JSON Schema
};

struct ApiOperation {
  ApiId id;
  boost::beast::http::verb method;  ///< HEAD is served where GET is
  std::string_view path;
  std::string_view name;     ///< operationId
  std::string_view summary;  ///< begins with a verb
  std::string_view notes;    ///< further sentences; may be empty
  Role least_role;
  std::span<const QueryParameter> query;
  std::string_view request_schema;  ///< a name in api_schemas(); empty: no body
  std::string_view example;         ///< of the body, JSON
  boost::beast::http::status success;
  std::string_view media_type;       ///< of the success
  std::string_view response_schema;  ///< a name in api_schemas(), of JSON; else empty
  std::vector<Problem> problems;     ///< besides those of every operation: see kUsualProblems
  bool takes_control_key;            ///< heeds the header kControlKeyHeader
};

/// What any operation may be refused by.
inline constexpr Problem kUsualProblems[] = {Problem::kMalformed, Problem::kNotAuthenticated,
                                             Problem::kNotPermitted, Problem::kMisdirected,
                                             Problem::kTooManyAttempts};

/// The key of a script that has asked for control: see ScriptSessions.
inline constexpr std::string_view kControlKeyHeader = "Fanlight-Control";

/// In the order of ApiId.
std::span<const ApiOperation> api_operations();

bool is_api(std::string_view path);

/// GET also stands for HEAD. Null: there is none.
const ApiOperation* find_operation(boost::beast::http::verb method, std::string_view path);

/// The methods that a path has, as in the field Allow: "GET, HEAD, PATCH"; empty: there is no such path.
std::string allowed_methods(std::string_view path);

}  // namespace fanlight
