// SPDX-License-Identifier: Apache-2.0
#include "server/codec/stream_settings.hpp"

#include <fmt/format.h>

#include <cmath>

namespace fanlight {

namespace {

constexpr std::uint32_t kLeastSide = 16;
constexpr std::uint32_t kMostSide = 4096;
constexpr std::uint32_t kLeastKbps = 50;
constexpr std::uint32_t kMostKbps = 200'000;
constexpr int kDefaultH264Kbps = 4000;
constexpr double kMostHz = 240;

Error outside(const char* field, double least, double most) {
  return {ErrorCode::kInvalidArgument, fmt::format("{}: expected 0, or {} to {}", field, least, most)};
}

bool within(double value, double least, double most) {
  return value == 0 || (value >= least && value <= most);
}

}  // namespace

Result<StreamSettings> parse_stream_request(const v1::StreamRequest& request, int default_quality) {
  if (!within(request.quality(), 1, 100)) return outside("quality", 1, 100);
  if (!within(request.bit_rate_kbps(), kLeastKbps, kMostKbps))
    return outside("bit_rate_kbps", kLeastKbps, kMostKbps);
  if (!within(request.width(), kLeastSide, kMostSide)) return outside("width", kLeastSide, kMostSide);
  if (!within(request.height(), kLeastSide, kMostSide)) return outside("height", kLeastSide, kMostSide);
  if (!within(request.rate_hz(), 0.1, kMostHz)) return outside("rate_hz", 0.1, kMostHz);
  StreamSettings settings{.bit_rate_kbps = static_cast<int>(request.bit_rate_kbps()),
                          .most_width = request.width(),
                          .most_height = request.height(),
                          .rate_hz = request.rate_hz(),
                          .with_depth = request.with_depth()};
  switch (request.codec()) {
    case v1::StreamRequest::JPEG:
      settings.codec = StreamSettings::Codec::kJpeg;
      if (settings.bit_rate_kbps == 0)
        settings.quality = request.quality() > 0 ? static_cast<int>(request.quality()) : default_quality;
      break;
    case v1::StreamRequest::PNG:
      settings.codec = StreamSettings::Codec::kPng;
      settings.bit_rate_kbps = 0;
      break;
    case v1::StreamRequest::H264:
      settings.codec = StreamSettings::Codec::kH264;
      if (settings.bit_rate_kbps == 0) settings.bit_rate_kbps = kDefaultH264Kbps;
      break;
    case v1::StreamRequest::SURFACE:
      settings.codec = StreamSettings::Codec::kSurface;
      settings.bit_rate_kbps = 0;
      settings.quality = request.quality() > 0 ? static_cast<int>(request.quality()) : default_quality;
      break;
    default:
      return Error{ErrorCode::kInvalidArgument, "codec: expected JPEG, PNG, H264 or SURFACE"};
  }
  return settings;
}

v1::StreamRequest stream_message(const StreamSettings& settings) {
  v1::StreamRequest message;
  message.set_codec(static_cast<v1::StreamRequest::Codec>(settings.codec));
  message.set_quality(static_cast<std::uint32_t>(settings.quality));
  message.set_bit_rate_kbps(static_cast<std::uint32_t>(settings.bit_rate_kbps));
  message.set_width(settings.most_width);
  message.set_height(settings.most_height);
  message.set_rate_hz(settings.rate_hz);
  message.set_with_depth(settings.with_depth);
  return message;
}

bool picture_due(double rate_hz, std::int64_t last_ns, std::int64_t now_ns) {
  if (rate_hz <= 0) return true;
  const auto grid_index = [&](std::int64_t ns) {
    return std::floor(static_cast<double>(ns) * rate_hz / 1e9);
  };
  return grid_index(now_ns) > grid_index(last_ns);
}

}  // namespace fanlight
