// SPDX-License-Identifier: Apache-2.0
#include "server/http/rtp_api.hpp"

#include "server/rtp/rtp_clock.hpp"

namespace fanlight {

namespace http = boost::beast::http;
using nlohmann::ordered_json;

ApiResponse RtpApi::respond(const ApiRequest& request, const Principal& principal) {
  if (request.method() == http::verb::get || request.method() == http::verb::head) return state(principal);
  if (request.method() == http::verb::post) return carry_out(request, principal);
  return wrong_method("GET or POST", "GET, HEAD, POST");
}

ApiResponse RtpApi::state(const Principal& principal) const {
  const std::optional<RtpSender>& sender = dependencies_.sender;
  if (!sender) return json_response(http::status::ok, {{"state", "no_receiver"}});
  ordered_json body = {{"state", sender->sending() ? "sending" : "stopped"},
                       {"to", sender->to()},
                       {"encrypted", sender->encrypted()}};
  if (const auto report = sender->report()) {
    body["receiver"] = {{"lost_percent", 100 * report->lost_share},
                        {"lost_packets", report->lost},
                        {"jitter_ms", report->jitter / (kRtpClockHz / 1000.0)}};
  }
  // It may hold the key.
  if (principal.role == Role::kAdmin) body["sdp"] = sender->description();
  return json_response(http::status::ok, body);
}

ApiResponse RtpApi::carry_out(const ApiRequest& request, const Principal& principal) {
  if (!is_json(request)) return expected_json();
  const std::string wish = wish_text(request);
  if (wish != "start" && wish != "stop") {
    dependencies_.counters.rtp_refusals.add();
    return refusal(http::status::bad_request,
                   R"(the wish is not known, expected {"wish": "start"} or "stop")");
  }
  std::optional<RtpSender>& sender = dependencies_.sender;
  Result<void> done;
  auto status = http::status::conflict;
  if (principal.role != Role::kAdmin) {
    status = http::status::forbidden;
    done = Error{ErrorCode::kInvalidArgument,
                 "the pictures leave the room by this, expected the role of an admin"};
  } else if (!sender) {
    done = Error{ErrorCode::kUnavailable, "the server was given no receiver, expected the option --rtp-to"};
  } else if (wish == "start") {
    done = sender->start();
  } else if (!sender->sending()) {
    done = Error{ErrorCode::kUnavailable, "nothing is sent, so there is nothing to stop"};
  } else {
    sender->stop();
  }
  const nlohmann::json details = {{"wish", wish}, {"to", sender ? sender->to() : ""}};
  dependencies_.audit.note(
      principal, {.what = "rtp", .result = done ? "done" : "refused: " + done.error().message}, details);
  if (done) return state(principal);
  dependencies_.counters.rtp_refusals.add();
  return refusal(status, done.error().message);
}

}  // namespace fanlight
