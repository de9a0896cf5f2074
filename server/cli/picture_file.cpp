// SPDX-License-Identifier: Apache-2.0
#include "server/cli/picture_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <initializer_list>
#include <string_view>
#include <system_error>
#include <vector>

#include "proto/base/file_replacement.hpp"
#include "proto/base/printable.hpp"
#include "proto/images/image_library.hpp"

namespace fanlight {

namespace {

// The library would note the time of writing: then the same picture would give other bytes.
constexpr const char* kNoTime = "";

Error unwritable(const std::string& path, std::string reason) {
  while (!reason.empty() && (reason.back() == '\n' || reason.back() == '.')) reason.pop_back();
  return {ErrorCode::kUnavailable, fmt::format("{} could not be written ({}), expected a name that ends in a "
                                               "picture format such as .png or .exr",
                                               path, reason)};
}

Result<void> write(const std::string& path, const ImageToWrite& image, const FileAccess& access) {
  const auto library = image_library();
  if (!library) return library.error();
  const bool to_output = path == kStandardOutput;
  // Its ending chooses the format.
  const auto encoded = (*library)->encode(to_output ? "picture.png" : path, image);
  if (!encoded) return unwritable(path, encoded.error().message);
  const std::vector<std::uint8_t>& bytes = *encoded;
  if (to_output) {
    if (std::fwrite(bytes.data(), 1, bytes.size(), stdout) == bytes.size()) return {};
    return Error{ErrorCode::kUnavailable,
                 "the picture could not be written to the standard output, expected room"};
  }
  return replace_file(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()}, access);
}

}  // namespace

Result<void> check_folder_of(const std::string& path) {
  if (path.empty()) return {};
  std::filesystem::path folder = std::filesystem::path(path).parent_path();
  if (folder.empty()) folder = ".";
  std::error_code unknown;
  if (std::filesystem::is_directory(path, unknown))
    return Error{ErrorCode::kNotFound,
                 fmt::format("{} could not be written (it is a folder), expected the name of a file",
                             printable(path))};
  if (access(folder.c_str(), W_OK | X_OK) == 0) return {};
  const int failure = errno;
  // A device or a file that is there may be written where its folder may not.
  if (access(path.c_str(), W_OK) == 0) return {};
  return Error{ErrorCode::kNotFound,
               fmt::format("{} could not be written ({}), expected an existing, writable folder",
                           printable(path), std::generic_category().message(failure))};
}

Result<void> check_picture_ending(const std::string& path) {
  const auto library = image_library();
  if (!library) return library.error();
  if (!(*library)->writes(path)) {
    return Error{
        ErrorCode::kInvalidArgument,
        fmt::format("{} could not be written (it ends in no picture format), expected a name such as "
                    "x.png, x.jpg, x.tif or x.exr, or - for the standard output",
                    printable(path))};
  }
  return {};
}

Result<void> check_picture_path(const std::string& path) {
  if (path == kStandardOutput) return {};
  if (auto good = check_picture_ending(path); !good) return good;
  return check_folder_of(path);
}

Result<void> write_picture(const std::string& path, const Picture& picture,
                           std::span<const std::string> notes, const FileAccess& access) {
  ImageToWrite image{.width = static_cast<int>(picture.width),
                     .height = static_cast<int>(picture.height),
                     .channels = 3,
                     .pixels = picture.rgba.data(),
                     .pixel_bytes = 4,
                     .attributes = {{"oiio:ColorSpace", "sRGB"}, {"DateTime", kNoTime}}};
  if (!notes.empty())
    image.attributes.emplace_back("ImageDescription", fmt::format("{}", fmt::join(notes, " ")));
  return write(path, image, access);
}

Result<void> check_depth_path(const std::string& path) {
  const std::initializer_list<std::string_view> endings = {".exr", ".tif", ".tiff"};
  if (path.empty() ||
      std::ranges::any_of(endings, [&path](std::string_view ending) { return path.ends_with(ending); }))
    return {};
  return Error{
      ErrorCode::kInvalidArgument,
      fmt::format(
          "{} could not be written (depth needs 32 bit floats), expected a name that ends in .exr or .tif",
          printable(path))};
}

Result<void> write_depth(const std::string& path, std::span<const float> depth_mm, std::uint32_t width,
                         std::uint32_t height, const PictureView& view, const FileAccess& access) {
  // Row order; its columns are right, down, forward and the origin, as in PictureView.
  std::array<float, 16> matrix{};
  for (std::size_t row = 0; row < 3; ++row) {
    std::size_t column = 0;
    for (const auto* axis : {&view.right, &view.down, &view.forward, &view.origin_mm})
      matrix[4 * row + column++] = static_cast<float>((*axis)[row]);
  }
  matrix[15] = 1;
  const auto number = [](double value) { return static_cast<float>(value); };
  const ImageToWrite image{
      .width = static_cast<int>(width),
      .height = static_cast<int>(height),
      .channels = 1,
      .floats = true,
      .pixels = depth_mm.data(),
      .pixel_bytes = sizeof(float),
      .attributes = {
          {"fanlight:camera", matrix},
          {"fanlight:projection", view.mm_per_pixel_per_mm > 0 ? "perspective" : "parallel"},
          {"fanlight:mm_per_pixel", number(view.mm_per_pixel)},
          {"fanlight:mm_per_pixel_per_mm", number(view.mm_per_pixel_per_mm)},
          {"fanlight:middle_column", number(view.middle_column)},
          {"fanlight:middle_row", number(view.middle_row)},
          {"fanlight:point",
           "origin + Z * forward + (mm_per_pixel + Z * mm_per_pixel_per_mm) * ((column - middle_column) * "
           "right + (row - middle_row) * down), mm"},
          {"compression", "zip"},
          {"DateTime", kNoTime}}};
  return write(path, image, access);
}

}  // namespace fanlight
