// SPDX-License-Identifier: Apache-2.0
#include "acquisition/igtl/sent_frames.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "acquisition/sequence/plus_fields.hpp"
#include "proto/igtl/timestamp.hpp"

namespace fanlight {

igtl::GridPose frame_place(const FanGeometry& geometry, double angle_rad) {
  if (geometry.polar()) return {};
  const auto vector = [](const Point& point) {
    return std::array<double, 3>{point.x_mm, point.y_mm, point.z_mm};
  };
  const PlanePoint first = geometry.plane_point({0, 0});
  const double cosine = std::cos(angle_rad);
  const double sine = std::sin(angle_rad);
  return {.i_mm = {geometry.pixel_width_mm, 0, 0},
          .j_mm = {0, geometry.pixel_height_mm * cosine, geometry.pixel_height_mm * sine},
          .k_mm = {0, -sine, cosine},
          .first_mm = vector(geometry.point(first.x_mm, {angle_rad, first.depth_mm}))};
}

std::span<const std::uint8_t> SentFrames::message(const QueuedFrame& frame, const Provenance& provenance,
                                                  igtl::HeadVersion version) {
  facts_.geometry = frame.geometry;
  PlusFields fields;
  if (version != igtl::HeadVersion::kOne) {
    fields = fanlight_fields(facts_);
    for (auto& field : frame_fields(facts_, {.stamp = frame.stamp})) fields.push_back(std::move(field));
    fields.emplace_back(plus_field::kOrigin, name_of(provenance.origin));
    fields.emplace_back(plus_field::kAgeMs,
                        fmt::format("{}", std::max<std::int64_t>(provenance.age_ns, 0) / 1'000'000));
  }
  const std::vector<std::pair<std::string_view, std::string_view>> items(fields.begin(), fields.end());
  igtl::ImageBody image{.pose = frame_place(frame.geometry, frame.stamp.angle_rad)};
  image.size = image.part_size = {static_cast<std::uint16_t>(frame.geometry.columns),
                                  static_cast<std::uint16_t>(frame.geometry.rows), 1};
  auto& bytes = writer_.begin({.type = "IMAGE",
                               .device = kDevice,
                               .timestamp = igtl::timestamp_of(provenance.utc_ns),
                               .version = version,
                               .message_id = static_cast<std::uint32_t>(frame.stamp.sequence),
                               .metadata = items});
  igtl::put_image_header(bytes, image);
  bytes.insert(bytes.end(), frame.pixels.begin(), frame.pixels.end());
  return writer_.finish();
}

}  // namespace fanlight
