// SPDX-License-Identifier: Apache-2.0
#include "server/codec/png_reader.hpp"

#include <fmt/format.h>
#include <png.h>

#include <cstring>
#include <memory>

namespace fanlight {

Result<RgbPicture> read_png(std::span<const std::uint8_t> file) {
  png_image image;
  std::memset(&image, 0, sizeof image);
  image.version = PNG_IMAGE_VERSION;
  const std::unique_ptr<png_image, decltype(&png_image_free)> owner(&image, png_image_free);
  const auto wrong = [&] {
    return Error{ErrorCode::kBadInput,
                 fmt::format("the picture is no PNG file, or is damaged ({}), expected one",
                             static_cast<const char*>(image.message))};
  };
  if (png_image_begin_read_from_memory(&image, file.data(), file.size()) == 0) return wrong();
  if (image.width > kMostPngSide || image.height > kMostPngSide) {
    return Error{ErrorCode::kBadInput, fmt::format("the picture has {} x {} pixels, expected at most {} x {}",
                                                   image.width, image.height, kMostPngSide, kMostPngSide)};
  }
  image.format = PNG_FORMAT_RGB;
  RgbPicture picture{.width = image.width, .height = image.height, .rgb = {}};
  picture.rgb.resize(PNG_IMAGE_SIZE(image));
  const png_color black{};
  if (png_image_finish_read(&image, &black, picture.rgb.data(), 0, nullptr) == 0) return wrong();
  return picture;
}

}  // namespace fanlight
