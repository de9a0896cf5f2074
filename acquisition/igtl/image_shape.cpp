// SPDX-License-Identifier: Apache-2.0
#include "acquisition/igtl/image_shape.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "proto/base/crc64.hpp"

namespace fanlight {

namespace {

// Lengths of one matrix differ in the last bits of its numbers.
constexpr double kSamePixelShare = 1e-3;

std::array<double, 2> pixel_mm(const igtl::GridPose& pose) {
  return {std::hypot(pose.i_mm[0], pose.i_mm[1], pose.i_mm[2]),
          std::hypot(pose.j_mm[0], pose.j_mm[1], pose.j_mm[2])};
}

/// Checksum of the fields that describe the geometry of all frames.
std::uint64_t described_by(const igtl::Metadata& metadata) {
  std::uint64_t sum = 0;
  const auto add = [&sum](std::string_view text) {
    sum = crc64({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}, sum);
  };
  metadata.for_each([&](std::string_view name, std::string_view value) {
    if (!name.starts_with("Fanlight")) return;
    add(name);
    add(value);
  });
  return sum;
}

}  // namespace

ImageShape ImageShape::of(const IgtlImage& image) {
  return {.size = image.body.size,
          .format = *pixel_format(image.body),
          .pixel_mm = fanlight::pixel_mm(image.body.pose),
          .described = described_by(image.metadata)};
}

bool ImageShape::matches(const ImageShape& other) const {
  const auto differs = [](double one, double two) {
    return std::abs(one - two) > kSamePixelShare * std::max(one, two);
  };
  return size == other.size && format == other.format && described == other.described &&
         !differs(pixel_mm[0], other.pixel_mm[0]) && !differs(pixel_mm[1], other.pixel_mm[1]);
}

}  // namespace fanlight
