// SPDX-License-Identifier: Apache-2.0
#include "acquisition/igtl/igtl_image.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "acquisition/sequence/tracked_poses.hpp"

namespace fanlight {

namespace {

ImagePose image_pose(const igtl::GridPose& grid) {
  ImagePose pose{};
  const std::array<double, 3>* const columns[] = {&grid.i_mm, &grid.j_mm, &grid.k_mm, &grid.first_mm};
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t column = 0; column < 4; ++column) pose[4 * row + column] = (*columns[column])[row];
  pose[15] = 1;
  return pose;
}

}  // namespace

std::optional<PixelFormat> pixel_format(const igtl::ImageBody& image) {
  using igtl::ScalarType;
  switch (image.scalar) {
    case ScalarType::kUint8:
      return PixelFormat{};
    case ScalarType::kInt8:
      return PixelFormat{.is_signed = true};
    case ScalarType::kUint16:
      return PixelFormat{.bytes = 2, .big_endian = image.big_endian};
    case ScalarType::kInt16:
      return PixelFormat{.bytes = 2, .is_signed = true, .big_endian = image.big_endian};
    default:
      return std::nullopt;
  }
}

std::string why_no_frame(const igtl::ImageBody& image) {
  if (image.size[2] != 1)
    return fmt::format("the image is a volume of {} slices, expected a 2D image", image.size[2]);
  if (image.components != 1)
    return fmt::format("a pixel has {} numbers, expected one: grey levels", image.components);
  if (!pixel_format(image)) {
    return fmt::format("the pixels have the type {}, expected whole numbers of 8 or 16 bit: 2 to 5",
                       static_cast<unsigned>(image.scalar));
  }
  const auto [smaller, larger] = std::minmax(image.size[0], image.size[1]);
  if (smaller < 2 || larger > 4096)
    return fmt::format("the image has {} x {} pixels, expected 2 to 4096 a side", image.size[0],
                       image.size[1]);
  return {};
}

std::optional<ImagePose> frame_pose(const igtl::GridPose& grid, const ImageOrientation& orientation,
                                    FrameSize size) {
  if (orientation.lines_in_rows) return std::nullopt;
  return turned(image_pose(grid), orientation, size);
}

FrameSize frame_size(const igtl::ImageBody& image, const ImageOrientation& orientation) {
  if (orientation.lines_in_rows) return {.columns = image.size[1], .rows = image.size[0]};
  return {.columns = image.size[0], .rows = image.size[1]};
}

}  // namespace fanlight
