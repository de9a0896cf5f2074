// SPDX-License-Identifier: Apache-2.0
#include "server/state/cine_proxy.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <utility>

#include "proto/base/printable.hpp"
#include "server/state/wish_text.hpp"

namespace fanlight {

namespace {

using v1::CineRequest;

constexpr std::array<std::pair<std::string_view, CineRequest::Wish>, 7> kCineWishes = {{
    {"freeze", CineRequest::FREEZE},
    {"live", CineRequest::LIVE},
    {"play", CineRequest::PLAY},
    {"pause", CineRequest::PAUSE},
    {"step", CineRequest::STEP},
    {"seek", CineRequest::SEEK},
    {"speed", CineRequest::SPEED},
}};
constexpr double kMostVolumes = 1e6;

bool has_value(CineRequest::Wish wish) {
  return wish == CineRequest::STEP || wish == CineRequest::SEEK || wish == CineRequest::SPEED;
}

Error unknown_cine_wish(std::string_view text) {
  return {ErrorCode::kInvalidArgument,
          fmt::format("{} for the cine, expected freeze, live, play, pause, step=VOLUMES, seek=VOLUME or "
                      "speed=FACTOR",
                      text.empty() ? "there is no wish"
                                   : fmt::format("\"{}\" is no wish", printable(text.substr(0, 40))))};
}

Result<CineOrder> order_of(const CineRequest& request) {
  using Wish = CineOrder::Wish;
  const auto bad = [](std::string sentence) {
    return Error{ErrorCode::kInvalidArgument, std::move(sentence)};
  };
  const double value = request.value();
  const bool whole = std::abs(value) <= kMostVolumes && value == std::floor(value);
  switch (request.wish()) {
    case CineRequest::FREEZE:
      return CineOrder{.wish = Wish::kFreeze, .volume_id = request.volume_id()};
    case CineRequest::LIVE:
      return CineOrder{.wish = Wish::kLive};
    case CineRequest::PLAY:
      return CineOrder{.wish = Wish::kPlay};
    case CineRequest::PAUSE:
      return CineOrder{.wish = Wish::kPause};
    case CineRequest::STEP:
      if (!whole || value == 0)
        return bad(fmt::format(
            "the step is {} volumes, expected a whole number other than 0, up to {:.0f} either way", value,
            kMostVolumes));
      return CineOrder{.wish = Wish::kStep, .volumes = static_cast<std::int32_t>(value)};
    case CineRequest::SEEK:
      if (!whole || value < 0)
        return bad(
            fmt::format("the volume is {}, expected a whole number from 0 to {:.0f}", value, kMostVolumes));
      return CineOrder{.wish = Wish::kSeek, .volume = static_cast<std::uint32_t>(value)};
    case CineRequest::SPEED:
      if (!(value >= kLeastCineSpeed && value <= kMostCineSpeed))
        return bad(fmt::format("the speed is {}, expected {} to {}", value, kLeastCineSpeed, kMostCineSpeed));
      return CineOrder{.wish = Wish::kSpeed, .speed = value};
    default:
      return bad("wish: expected FREEZE, LIVE, PLAY, PAUSE, STEP, SEEK or SPEED");
  }
}

}  // namespace

Result<CineRequest> cine_request(std::string_view text) {
  const WishText written(text);
  for (const auto& [known, wish] : kCineWishes) {
    if (written.word != known) continue;
    CineRequest request;
    request.set_wish(wish);
    if (!has_value(wish))
      return written.has_argument ? Result<CineRequest>(unknown_cine_wish(text)) : request;
    const bool usual_step = wish == CineRequest::STEP && !written.has_argument;
    const auto value = usual_step ? 1.0 : written.number();
    if (!value) return unknown_cine_wish(text);
    request.set_value(*value);
    return request;
  }
  return unknown_cine_wish(text);
}

std::string cine_words(const CineRequest& request) {
  for (const auto& [word, wish] : kCineWishes) {
    if (wish != request.wish()) continue;
    return has_value(wish) ? fmt::format("{}={}", word, request.value()) : std::string(word);
  }
  return "unknown";
}

Result<void> CineProxy::request(const CineRequest& request) {
  const auto order = order_of(request);
  if (!order) return order.error();
  if (link_.send(*order)) return {};
  return Error{ErrorCode::kUnavailable, "the renderer has many requests to carry out, try again in a moment"};
}

v1::CineStatus CineProxy::message() const {
  v1::CineStatus message;
  message.set_state(static_cast<v1::CineStatus::State>(status_.state));
  message.set_capacity(status_.capacity);
  message.set_volumes(status_.volumes);
  message.set_volume(status_.volume);
  message.set_time_s(status_.time_s);
  message.set_duration_s(status_.duration_s);
  message.set_speed(status_.speed);
  message.set_volume_id(status_.volume_id);
  return message;
}

}  // namespace fanlight
