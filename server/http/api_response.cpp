// SPDX-License-Identifier: Apache-2.0
#include "server/http/api_response.hpp"

#include <fmt/format.h>

#include "server/state/scene_json.hpp"

namespace fanlight {

namespace http = boost::beast::http;
using nlohmann::ordered_json;

ApiResponse json_response(http::status status, const ordered_json& body) {
  ApiResponse response(status, 11);
  response.set(http::field::content_type, "application/json");
  response.body() = body.dump(1, ' ', false, ordered_json::error_handler_t::replace) + "\n";
  return response;
}

ApiResponse refusal(http::status status, const std::string& sentence, const SceneField* field) {
  ordered_json error = {{"message", sentence}};
  if (field != nullptr) error.update(range_json(*field));
  return json_response(status, {{"error", error}});
}

ApiResponse wrong_method(std::string_view expected, std::string_view allowed) {
  ApiResponse response =
      refusal(http::status::method_not_allowed, fmt::format("expected the method {}", expected));
  response.set(http::field::allow, allowed);
  return response;
}

bool is_json(const ApiRequest& request) {
  const std::string_view type = request[http::field::content_type];
  return type.starts_with("application/json") || type.starts_with("application/merge-patch+json");
}

ApiResponse expected_json() {
  return refusal(http::status::unsupported_media_type, "expected Content-Type: application/json");
}

std::string wish_text(const ApiRequest& request) {
  const auto parsed = nlohmann::json::parse(request.body(), nullptr, false);
  const auto text = parsed.is_object() ? parsed.value("wish", nlohmann::json()) : nlohmann::json();
  return text.is_string() ? text.get<std::string>() : "";
}

}  // namespace fanlight
