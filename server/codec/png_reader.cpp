// SPDX-License-Identifier: Apache-2.0
#include "server/codec/png_reader.hpp"

#include <fmt/format.h>
#include <png.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <string_view>

namespace fanlight {

namespace {

constexpr std::size_t kSignatureBytes = 8;
constexpr std::size_t kChunkBytes = 12;  // length, type and checksum, each of 4

std::uint32_t big_endian(std::span<const std::uint8_t> bytes) {
  return std::uint32_t{bytes[0]} << 24U | std::uint32_t{bytes[1]} << 16U | std::uint32_t{bytes[2]} << 8U |
         std::uint32_t{bytes[3]};
}

Error damaged(std::string_view problem) {
  return {ErrorCode::kBadInput,
          fmt::format("the picture is no PNG file, or is damaged ({}), expected one", problem)};
}

/// The file with the chunks that its pixels need (PNG, 5.3). libpng unpacks texts and colour profiles, of
/// megabytes each, before the size of the picture can be asked for.
Result<std::vector<std::uint8_t>> without_other_chunks(std::span<const std::uint8_t> file) {
  constexpr std::array<std::string_view, 7> kNeeded{"IHDR", "PLTE", "tRNS", "gAMA", "sRGB", "IDAT", "IEND"};
  if (file.size() < kSignatureBytes || png_sig_cmp(file.data(), 0, kSignatureBytes) != 0)
    return damaged("its first bytes are others");
  std::vector<std::uint8_t> kept(file.begin(), file.begin() + kSignatureBytes);
  for (auto rest = file.subspan(kSignatureBytes); rest.size() >= kChunkBytes;) {
    const std::size_t bytes = std::size_t{big_endian(rest)} + kChunkBytes;
    if (bytes > rest.size()) return damaged("it is cut off");
    const std::string_view type(reinterpret_cast<const char*>(rest.data()) + 4, 4);
    if (std::ranges::find(kNeeded, type) != kNeeded.end())
      kept.insert(kept.end(), rest.begin(), rest.begin() + bytes);
    rest = rest.subspan(bytes);
  }
  return kept;
}

}  // namespace

Result<RgbPicture> read_png(std::span<const std::uint8_t> file) {
  const auto needed = without_other_chunks(file);
  if (!needed) return needed.error();
  png_image image;
  std::memset(&image, 0, sizeof image);
  image.version = PNG_IMAGE_VERSION;
  const std::unique_ptr<png_image, decltype(&png_image_free)> owner(&image, png_image_free);
  if (png_image_begin_read_from_memory(&image, needed->data(), needed->size()) == 0)
    return damaged(image.message);
  if (image.width > kMostPngSide || image.height > kMostPngSide) {
    return Error{ErrorCode::kBadInput, fmt::format("the picture has {} x {} pixels, expected at most {} x {}",
                                                   image.width, image.height, kMostPngSide, kMostPngSide)};
  }
  image.format = PNG_FORMAT_RGB;
  RgbPicture picture{.width = image.width, .height = image.height, .rgb = {}};
  picture.rgb.resize(PNG_IMAGE_SIZE(image));
  const png_color black{};
  if (png_image_finish_read(&image, &black, picture.rgb.data(), 0, nullptr) == 0)
    return damaged(image.message);
  return picture;
}

}  // namespace fanlight
