// SPDX-License-Identifier: Apache-2.0
#include "proto/igtl/image_body.hpp"

#include <openigtlink/igtl_image.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace fanlight::igtl {

namespace {

static_assert(sizeof(igtl_image_header) == kImageHeaderBytes);

/// From the first pixel of a grid to its centre.
std::array<double, 3> to_centre_mm(const std::array<std::uint16_t, 3>& size, const GridPose& pose) {
  std::array<double, 3> way_mm{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    way_mm[axis] = (size[0] - 1) / 2.0 * pose.i_mm[axis] + (size[1] - 1) / 2.0 * pose.j_mm[axis] +
                   (size[2] - 1) / 2.0 * pose.k_mm[axis];
  }
  return way_mm;
}

std::array<double, 3> vector_of(const igtl_float32* from, double sign) {
  return {sign * from[0], sign * from[1], from[2]};
}

bool is_finite(const std::array<double, 3>& vector) {
  return std::ranges::all_of(vector, [](double each) { return std::isfinite(each); });
}

bool fits(const ImageBody& image) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (image.size[axis] == 0 || image.part_size[axis] == 0) return false;
    if (image.part_offset[axis] + image.part_size[axis] > image.size[axis]) return false;
  }
  return image.components > 0 && bytes_of(image.scalar) > 0;
}

}  // namespace

std::size_t bytes_of(ScalarType type) {
  switch (type) {
    case ScalarType::kInt8:
    case ScalarType::kUint8:
      return 1;
    case ScalarType::kInt16:
    case ScalarType::kUint16:
      return 2;
    case ScalarType::kInt32:
    case ScalarType::kUint32:
    case ScalarType::kFloat32:
      return 4;
    case ScalarType::kFloat64:
      return 8;
  }
  return 0;
}

std::array<float, 12> grid_matrix(const std::array<std::uint16_t, 3>& size, const GridPose& pose) {
  std::array<double, 3> centre_mm = to_centre_mm(size, pose);
  for (std::size_t axis = 0; axis < 3; ++axis) centre_mm[axis] += pose.first_mm[axis];
  std::array<float, 12> numbers{};
  auto next = numbers.begin();
  for (const auto& column : {pose.i_mm, pose.j_mm, pose.k_mm, centre_mm})
    for (const double number : column) *next++ = static_cast<float>(number);
  return numbers;
}

std::optional<ReceivedImage> parse_image(std::span<const std::uint8_t> content) {
  if (content.size() < kImageHeaderBytes) return std::nullopt;
  igtl_image_header packed;
  std::memcpy(&packed, content.data(), kImageHeaderBytes);
  igtl_image_convert_byte_order(&packed);
  const bool known_order =
      packed.endian == IGTL_IMAGE_ENDIAN_BIG || packed.endian == IGTL_IMAGE_ENDIAN_LITTLE;
  const bool known_axes = packed.coord == IGTL_IMAGE_COORD_RAS || packed.coord == IGTL_IMAGE_COORD_LPS;
  if (packed.version != IGTL_IMAGE_HEADER_VERSION || !known_order || !known_axes) return std::nullopt;
  ReceivedImage image{.pixels = content.subspan(kImageHeaderBytes)};
  ImageBody& body = image.body;
  body.components = packed.num_components;
  body.scalar = static_cast<ScalarType>(packed.scalar_type);
  body.big_endian = packed.endian == IGTL_IMAGE_ENDIAN_BIG;
  std::ranges::copy(packed.size, body.size.begin());
  std::ranges::copy(packed.subvol_offset, body.part_offset.begin());
  std::ranges::copy(packed.subvol_size, body.part_size.begin());
  if (!fits(body) || body.part_bytes() != image.pixels.size()) return std::nullopt;
  // x and y of LPS point the other way.
  const double sign = packed.coord == IGTL_IMAGE_COORD_LPS ? -1 : 1;
  body.pose = {vector_of(packed.matrix, sign), vector_of(packed.matrix + 3, sign),
               vector_of(packed.matrix + 6, sign), vector_of(packed.matrix + 9, sign)};
  const auto way_mm = to_centre_mm(body.size, body.pose);
  for (std::size_t axis = 0; axis < 3; ++axis) body.pose.first_mm[axis] -= way_mm[axis];
  if (!is_finite(body.pose.i_mm) || !is_finite(body.pose.j_mm) || !is_finite(body.pose.k_mm) ||
      !is_finite(body.pose.first_mm))
    return std::nullopt;
  return image;
}

void put_image_header(std::vector<std::uint8_t>& bytes, const ImageBody& image) {
  igtl_image_header packed{};
  packed.version = IGTL_IMAGE_HEADER_VERSION;
  packed.num_components = image.components;
  packed.scalar_type = static_cast<igtl_uint8>(image.scalar);
  packed.endian = image.big_endian ? IGTL_IMAGE_ENDIAN_BIG : IGTL_IMAGE_ENDIAN_LITTLE;
  packed.coord = IGTL_IMAGE_COORD_RAS;
  std::ranges::copy(image.size, packed.size);
  std::ranges::copy(image.part_offset, packed.subvol_offset);
  std::ranges::copy(image.part_size, packed.subvol_size);
  std::ranges::copy(grid_matrix(image.size, image.pose), packed.matrix);
  igtl_image_convert_byte_order(&packed);
  const auto* const raw = reinterpret_cast<const std::uint8_t*>(&packed);
  bytes.insert(bytes.end(), raw, raw + kImageHeaderBytes);
}

}  // namespace fanlight::igtl
