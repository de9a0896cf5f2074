// SPDX-License-Identifier: Apache-2.0
#include "server/codec/png_coder.hpp"

#include <fmt/format.h>
#include <png.h>

#include <cstring>

namespace fanlight {

Result<CodedPicture> PngCoder::encode(const Pixels& pixels, bool /*key*/) {
  png_image image;
  std::memset(&image, 0, sizeof image);
  image.version = PNG_IMAGE_VERSION;
  image.width = pixels.width;
  image.height = pixels.height;
  image.format = PNG_FORMAT_RGBA;
  image.flags = PNG_IMAGE_FLAG_FAST;
  png_alloc_size_t bytes = PNG_IMAGE_PNG_SIZE_MAX(image);
  png_.resize(bytes);
  if (png_image_write_to_memory(&image, png_.data(), &bytes, 0, pixels.rgba.data(), 0, nullptr) == 0) {
    return Error{ErrorCode::kBroken, fmt::format("encoding a picture of {} x {} failed: {}", pixels.width,
                                                 pixels.height, image.message)};
  }
  return CodedPicture{.bytes = {png_.data(), bytes}};
}

}  // namespace fanlight
