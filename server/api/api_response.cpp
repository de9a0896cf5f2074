// SPDX-License-Identifier: Apache-2.0
#include "server/api/api_response.hpp"

#include <google/protobuf/message.h>

#include <algorithm>
#include <cctype>
#include <string>
#include <string_view>

namespace fanlight {

namespace http = boost::beast::http;
using nlohmann::ordered_json;

ApiResponse json_response(http::status status, const ordered_json& body) {
  ApiResponse response(status, 11);
  response.set(http::field::content_type, "application/json");
  response.body() = body.dump(1, ' ', false, ordered_json::error_handler_t::replace) + "\n";
  return response;
}

ordered_json message_json(const google::protobuf::Message& message) {
  using Field = google::protobuf::FieldDescriptor;
  const auto* const reflection = message.GetReflection();
  const auto* const descriptor = message.GetDescriptor();
  ordered_json json = ordered_json::object();
  for (int index = 0; index < descriptor->field_count(); ++index) {
    const Field* const field = descriptor->field(index);
    ordered_json& value = json[field->name()];
    switch (field->cpp_type()) {
      case Field::CPPTYPE_BOOL:
        value = reflection->GetBool(message, field);
        break;
      case Field::CPPTYPE_DOUBLE:
        value = reflection->GetDouble(message, field);
        break;
      case Field::CPPTYPE_UINT32:
        value = reflection->GetUInt32(message, field);
        break;
      case Field::CPPTYPE_UINT64:
        value = reflection->GetUInt64(message, field);
        break;
      case Field::CPPTYPE_STRING:
        value = reflection->GetString(message, field);
        break;
      case Field::CPPTYPE_ENUM: {
        std::string name(reflection->GetEnum(message, field)->name());
        std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
        value = name;
        break;
      }
      default:
        break;
    }
  }
  return json;
}

bool is_json(const ApiRequest& request) {
  const std::string_view type = request[http::field::content_type];
  return type.starts_with("application/json") || type.starts_with("application/merge-patch+json");
}

}  // namespace fanlight
