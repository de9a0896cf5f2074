// SPDX-License-Identifier: Apache-2.0
#include "server/state/replay_proxy.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <utility>

#include "proto/base/printable.hpp"
#include "server/state/path_privacy.hpp"
#include "server/state/wish_text.hpp"

namespace fanlight {

namespace {

using v1::ReplayRequest;

constexpr std::array<std::pair<std::string_view, ReplayRequest::Wish>, 7> kWishes = {{
    {"play", ReplayRequest::PLAY},
    {"pause", ReplayRequest::PAUSE},
    {"step", ReplayRequest::STEP},
    {"seek", ReplayRequest::SEEK},
    {"speed", ReplayRequest::SPEED},
    {"ending", ReplayRequest::ENDING},
    {"frame", ReplayRequest::FRAME},
}};
constexpr std::array<std::string_view, 3> kEndings = {"once", "loop", "to-and-fro"};
constexpr double kMostSweeps = 1e6;
constexpr double kMostExact = 9'007'199'254'740'992;  // 2^53: a double has each whole number up to it

Error unknown(std::string_view text) {
  return {ErrorCode::kInvalidArgument,
          fmt::format("{} for the replay, expected play, pause, step=SWEEPS, seek=SECONDS, "
                      "frame=NUMBER, speed=FACTOR or ending=once|loop|to-and-fro",
                      text.empty() ? "there is no wish"
                                   : fmt::format("\"{}\" is no wish", printable(text.substr(0, 40))))};
}

Result<ReplayOrder> order_of(const ReplayRequest& request) {
  const auto bad = [](std::string sentence) {
    return Error{ErrorCode::kInvalidArgument, std::move(sentence)};
  };
  const double value = request.value();
  switch (request.wish()) {
    case ReplayRequest::PLAY:
      return ReplayOrder{.wish = ReplayOrder::Wish::kPlay};
    case ReplayRequest::PAUSE:
      return ReplayOrder{.wish = ReplayOrder::Wish::kPause};
    case ReplayRequest::STEP:
      if (!(std::abs(value) >= 1 && std::abs(value) <= kMostSweeps && value == std::floor(value)))
        return bad(fmt::format("the step is {} sweeps, expected a whole number other than 0", value));
      return ReplayOrder{.wish = ReplayOrder::Wish::kStep, .sweeps = static_cast<std::int32_t>(value)};
    case ReplayRequest::SEEK:
      if (!(value >= 0 && std::isfinite(value)))
        return bad(fmt::format("the place is {} s, expected 0 or more", value));
      return ReplayOrder{.wish = ReplayOrder::Wish::kSeek, .time_s = value};
    case ReplayRequest::FRAME:
      if (!(value >= 0 && value <= kMostExact && value == std::floor(value)))
        return bad(fmt::format("the frame is {}, expected a whole number from 0 on", value));
      return ReplayOrder{.wish = ReplayOrder::Wish::kFrame, .number = static_cast<std::uint64_t>(value)};
    case ReplayRequest::SPEED:
      if (!(value >= kLeastReplaySpeed && value <= kMostReplaySpeed)) {
        return bad(
            fmt::format("the speed is {}, expected {} to {}", value, kLeastReplaySpeed, kMostReplaySpeed));
      }
      return ReplayOrder{.wish = ReplayOrder::Wish::kSpeed, .speed = value};
    case ReplayRequest::ENDING:
      if (!v1::ReplayStatus::Ending_IsValid(request.ending()))
        return bad("the ending is not known, expected ONCE, LOOP or TO_AND_FRO");
      return ReplayOrder{.wish = ReplayOrder::Wish::kEnding,
                         .ending = static_cast<ReplayEnding>(request.ending())};
    default:
      return bad("wish: expected PLAY, PAUSE, STEP, SEEK, FRAME, SPEED or ENDING");
  }
}

std::string trouble_of(const ReplayStatus& status) {
  if (!status.trouble.empty()) return status.trouble;
  switch (status.file) {
    case ReplayStatus::File::kSame:
      return "";
    case ReplayStatus::File::kChanged:
      return "The recording's file has been changed since it was opened.";
    case ReplayStatus::File::kRemoved:
      break;
  }
  return "The recording's file has been removed; what was opened is played on.";
}

}  // namespace

Result<ReplayRequest> replay_request(std::string_view text) {
  const WishText written(text);
  for (const auto& [known, wish] : kWishes) {
    if (written.word != known) continue;
    ReplayRequest request;
    request.set_wish(wish);
    if (wish == ReplayRequest::PLAY || wish == ReplayRequest::PAUSE) {
      if (written.has_argument) return unknown(text);
      return request;
    }
    if (wish == ReplayRequest::ENDING) {
      for (std::size_t i = 0; i < kEndings.size(); ++i) {
        if (written.argument != kEndings[i]) continue;
        request.set_ending(static_cast<v1::ReplayStatus::Ending>(i));
        return request;
      }
      return unknown(text);
    }
    const auto value = !written.has_argument && wish == ReplayRequest::STEP ? 1.0 : written.number();
    if (!value) return unknown(text);
    request.set_value(*value);
    return request;
  }
  return unknown(text);
}

std::string_view replay_ending_name(v1::ReplayStatus::Ending ending) {
  return v1::ReplayStatus::Ending_IsValid(ending) ? kEndings[static_cast<std::size_t>(ending)] : "unknown";
}

std::string replay_words(const ReplayRequest& request) {
  for (const auto& [word, wish] : kWishes) {
    if (wish != request.wish()) continue;
    if (wish == ReplayRequest::PLAY || wish == ReplayRequest::PAUSE) return std::string(word);
    if (wish == ReplayRequest::ENDING)
      return fmt::format("{}={}", word, replay_ending_name(request.ending()));
    return fmt::format("{}={}", word, request.value());
  }
  return "unknown";
}

Result<void> ReplayProxy::request(const ReplayRequest& request) {
  if (!is_replay())
    return Error{ErrorCode::kUnavailable, "the source is no recording, expected one to be played"};
  const auto order = order_of(request);
  if (!order) return order.error();
  if (order->wish == ReplayOrder::Wish::kEnding && order->ending == ReplayEnding::kToAndFro &&
      !status_.can_play_backward) {
    return Error{ErrorCode::kUnavailable,
                 "the recording is compressed and read as it plays, which goes forward only; expected the "
                 "server to be started with --ending to-and-fro, which reads it into memory"};
  }
  if (link_.send(*order)) return {};
  return Error{ErrorCode::kUnavailable, "the player has many requests to carry out, try again in a moment"};
}

bool ReplayProxy::update() {
  const ReplayStatus* const newest = link_.status.newest();
  if (newest == nullptr) return false;
  status_ = *newest;
  status_.trouble = without_path(std::move(status_.trouble), path_, "the recording");
  return true;
}

v1::ReplayStatus ReplayProxy::message() const {
  v1::ReplayStatus message;
  message.set_state(static_cast<v1::ReplayStatus::State>(status_.state));
  if (!is_replay()) return message;
  message.set_backward(status_.backward);
  message.set_ending(static_cast<v1::ReplayStatus::Ending>(status_.ending));
  message.set_sweep(status_.sweep);
  message.set_sweeps(status_.sweeps);
  message.set_time_s(status_.time_s);
  message.set_duration_s(status_.duration_s);
  message.set_speed(status_.speed);
  message.set_trouble(trouble_of(status_));
  return message;
}

}  // namespace fanlight
