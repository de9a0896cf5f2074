// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "proto/igtl/image_body.hpp"
#include "proto/igtl/message_writer.hpp"
#include "proto/igtl/pose_bodies.hpp"
#include "proto/igtl/timestamp.hpp"
#include "proto/model/fan_geometry.hpp"

// Messages as a scanner sends them.
namespace fanlight::test {

using Bytes = std::vector<std::uint8_t>;
using Items = std::vector<std::pair<std::string, std::string>>;

inline std::vector<std::pair<std::string_view, std::string_view>> views_of(const Items& items) {
  return {items.begin(), items.end()};
}

struct SentImage {
  std::uint16_t columns = 16;
  std::uint16_t rows = 12;
  std::uint8_t grey = 100;  ///< of all pixels
  igtl::GridPose pose;
  Items metadata;
  std::uint64_t time_ms = 1'700'000'000'000;  ///< since 1970
  std::string device = "Image_Reference";
};

inline igtl::ImageBody body_of(const SentImage& sent) {
  igtl::ImageBody body;
  body.size = body.part_size = {sent.columns, sent.rows, 1};
  body.pose = sent.pose;
  return body;
}

/// With metadata, in version 2.
inline Bytes message_of(const SentImage& sent, const igtl::ImageBody& body,
                        std::span<const std::uint8_t> pixels) {
  igtl::MessageWriter writer;
  const auto items = views_of(sent.metadata);
  auto& bytes = writer.begin({.type = "IMAGE",
                              .device = igtl::DeviceName(sent.device),
                              .timestamp = igtl::timestamp_of(sent.time_ms * 1'000'000),
                              .version = items.empty() ? igtl::HeadVersion::kOne : igtl::HeadVersion::kTwo,
                              .metadata = items});
  igtl::put_image_header(bytes, body);
  bytes.insert(bytes.end(), pixels.begin(), pixels.end());
  const auto message = writer.finish();
  return {message.begin(), message.end()};
}

inline Bytes message_of(const SentImage& sent) {
  const igtl::ImageBody body = body_of(sent);
  return message_of(sent, body, Bytes(body.part_bytes(), sent.grey));
}

inline Bytes transform_message(const std::string& device, std::uint64_t time_ms, const igtl::GridPose& pose) {
  igtl::MessageWriter writer;
  igtl::put_transform(writer.begin({.type = "TRANSFORM",
                                    .device = igtl::DeviceName(device),
                                    .timestamp = igtl::timestamp_of(time_ms * 1'000'000)}),
                      pose);
  const auto message = writer.finish();
  return {message.begin(), message.end()};
}

/// The fan of a probe: row 0 is its face, the middle column its middle.
struct SentFan {
  double pixel_mm = 0.5;
  double motor_radius_mm = 30;
  std::uint16_t columns = 16;

  /// Of the frame at an angle, in the transducer frame turned and moved by nothing.
  igtl::GridPose pose(double angle_deg) const {
    const double angle = radians(angle_deg);
    const double middle = (columns - 1) / 2.0;
    return {.i_mm = {pixel_mm, 0, 0},
            .j_mm = {0, pixel_mm * std::cos(angle), pixel_mm * std::sin(angle)},
            .k_mm = {0, -std::sin(angle), std::cos(angle)},
            .first_mm = {-middle * pixel_mm, motor_radius_mm * std::cos(angle) - motor_radius_mm,
                         motor_radius_mm * std::sin(angle)}};
  }
};

/// To and fro over `frames` a sweep, from -20 to 20 deg.
inline double angle_deg(std::uint32_t index, std::uint32_t frames) {
  const std::uint32_t within = index % frames;
  const double share = static_cast<double>(within) / (frames - 1);
  return index / frames % 2 == 0 ? -20 + 40 * share : 20 - 40 * share;
}

}  // namespace fanlight::test
