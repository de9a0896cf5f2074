// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/beast/http/status.hpp>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "proto/model/scene.hpp"
#include "server/api/api_response.hpp"

namespace fanlight {

/// Why a request was refused.
enum class Problem : std::uint8_t {
  kMalformed,
  kNotAuthenticated,
  kNotPermitted,
  kNotFound,
  kMethodNotAllowed,
  kNotPossibleNow,
  kControlHeld,
  kControlLapsed,
  kTooLarge,
  kMediaType,
  kExpectation,
  kMisdirected,
  kValueNotAllowed,
  kTooManyAttempts,
  kHeaderTooLarge,
  kFailed,
  kUnavailable,
};

struct ProblemType {
  Problem problem;
  boost::beast::http::status status;
  std::string_view name;   ///< part of the URN, for programs: "control-held"
  std::string_view title;  ///< for people; the same for all problems of this type
};

/// One row for each Problem, in its order.
std::span<const ProblemType> problem_types();
const ProblemType& type_of(Problem problem);
/// "urn:fanlight:problem:control-held".
std::string problem_urn(Problem problem);

/// The problem that a status stands for, where the status alone is known.
Problem problem_of(boost::beast::http::status status);

/// Problem details as application/problem+json (RFC 9457): type, title, status and `detail`, one sentence
/// for people; with the name and the range of the field that was refused.
ApiResponse refusal(Problem problem, const std::string& detail, const SceneField* field = nullptr);
ApiResponse refusal(boost::beast::http::status status, const std::string& detail);

/// `expected`: for people; `allowed`: as in the field Allow.
ApiResponse wrong_method(std::string_view expected, std::string_view allowed);
ApiResponse expected_json();

}  // namespace fanlight
