// SPDX-License-Identifier: Apache-2.0
#include "server/api/problem.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "server/state/scene_json.hpp"

namespace fanlight {

namespace http = boost::beast::http;
using nlohmann::ordered_json;

namespace {

constexpr auto kTypes = std::to_array<ProblemType>({
    {Problem::kMalformed, http::status::bad_request, "malformed", "The request cannot be read"},
    {Problem::kNotAuthenticated, http::status::unauthorized, "not-authenticated",
     "The request shows no valid token or certificate"},
    {Problem::kNotPermitted, http::status::forbidden, "not-permitted", "The client may not do this"},
    {Problem::kNotFound, http::status::not_found, "not-found", "There is no such thing"},
    {Problem::kMethodNotAllowed, http::status::method_not_allowed, "method-not-allowed",
     "This address has no such method"},
    {Problem::kNotPossibleNow, http::status::conflict, "not-possible-now",
     "The state of the server does not allow this"},
    {Problem::kControlHeld, http::status::conflict, "control-held", "Another client is in control"},
    {Problem::kControlLapsed, http::status::conflict, "control-lapsed",
     "The control key is not known or has lapsed"},
    {Problem::kTooLarge, http::status::payload_too_large, "too-large", "The body is too large"},
    {Problem::kMediaType, http::status::unsupported_media_type, "media-type",
     "The body has another media type"},
    {Problem::kExpectation, http::status::expectation_failed, "expectation",
     "The Expect header cannot be met"},
    {Problem::kMisdirected, http::status::misdirected_request, "misdirected",
     "The request names another host"},
    {Problem::kValueNotAllowed, http::status::unprocessable_entity, "value-not-allowed",
     "The scene has no such field or value"},
    {Problem::kTooManyAttempts, http::status::too_many_requests, "too-many-attempts",
     "Too many logins have failed"},
    {Problem::kHeaderTooLarge, http::status::request_header_fields_too_large, "header-too-large",
     "The header is too large"},
    {Problem::kFailed, http::status::internal_server_error, "failed", "The server has failed"},
    {Problem::kUnavailable, http::status::service_unavailable, "unavailable", "A later request may succeed"},
});

}  // namespace

std::span<const ProblemType> problem_types() {
  return kTypes;
}

const ProblemType& type_of(Problem problem) {
  return kTypes.at(static_cast<std::size_t>(problem));
}

std::string problem_urn(Problem problem) {
  return fmt::format("urn:fanlight:problem:{}", type_of(problem).name);
}

Problem problem_of(http::status status) {
  const auto* const found = std::ranges::find(kTypes, status, &ProblemType::status);
  if (found != kTypes.end()) return found->problem;
  return http::to_status_class(status) == http::status_class::server_error ? Problem::kFailed
                                                                           : Problem::kMalformed;
}

ApiResponse refusal(Problem problem, const std::string& detail, const SceneField* field) {
  const ProblemType& type = type_of(problem);
  ordered_json body = {{"type", problem_urn(problem)},
                       {"title", type.title},
                       {"status", static_cast<unsigned>(type.status)},
                       {"detail", detail}};
  if (field != nullptr) body.update(range_json(*field));
  ApiResponse response = json_response(type.status, body);
  response.set(http::field::content_type, "application/problem+json");
  if (problem == Problem::kUnavailable) response.set(http::field::retry_after, "1");
  return response;
}

ApiResponse refusal(http::status status, const std::string& detail) {
  return refusal(problem_of(status), detail);
}

ApiResponse wrong_method(std::string_view expected, std::string_view allowed) {
  ApiResponse response = refusal(Problem::kMethodNotAllowed, fmt::format("expected the method {}", expected));
  response.set(http::field::allow, allowed);
  return response;
}

ApiResponse expected_json() {
  return refusal(Problem::kMediaType, "expected Content-Type: application/json");
}

}  // namespace fanlight
