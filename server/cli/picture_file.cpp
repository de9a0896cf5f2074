// SPDX-License-Identifier: Apache-2.0
#include "server/cli/picture_file.hpp"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <system_error>

#include "proto/base/file_replacement.hpp"
#include "proto/base/printable.hpp"

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

/// Encodes in memory: the library reports no error of a full disk where it writes to a file itself.
Result<void> write(const std::string& path, const OIIO::ImageSpec& spec, const OIIO::TypeDesc& type,
                   const void* pixels, OIIO::stride_t pixel_stride, const FileAccess& access) {
  const bool to_output = path == kStandardOutput;
  const std::string name = to_output ? "picture.png" : path;  // its ending chooses the format
  const auto output = OIIO::ImageOutput::create(name);
  if (!output) return unwritable(path, OIIO::geterror());
  OIIO::Filesystem::IOVecOutput encoded;
  if (!output->supports("ioproxy") || !output->set_ioproxy(&encoded)) {
    return unwritable(path, fmt::format("the format {} is not supported", output->format_name()));
  }
  if (!output->open(name, spec) || !output->write_image(type, pixels, pixel_stride) || !output->close()) {
    return unwritable(path, output->geterror());
  }
  const auto& bytes = encoded.buffer();
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
  if (!OIIO::ImageOutput::create(path)) {
    (void)OIIO::geterror();
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
  OIIO::ImageSpec spec(static_cast<int>(picture.width), static_cast<int>(picture.height), 3,
                       OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:ColorSpace", "sRGB");
  spec.attribute("DateTime", kNoTime);
  if (!notes.empty()) spec.attribute("ImageDescription", fmt::format("{}", fmt::join(notes, " ")));
  return write(path, spec, OIIO::TypeDesc::UINT8, picture.rgba.data(), 4, access);
}

Result<void> check_depth_path(const std::string& path) {
  if (path.empty() || path.ends_with(".exr")) return {};
  return Error{
      ErrorCode::kInvalidArgument,
      fmt::format("{} could not be written (depth needs 32 bit floats), expected a name that ends in .exr",
                  printable(path))};
}

Result<void> write_depth(const std::string& path, std::span<const float> depth_mm, std::uint32_t width,
                         std::uint32_t height, const PictureView& view, const FileAccess& access) {
  OIIO::ImageSpec spec(static_cast<int>(width), static_cast<int>(height), 1, OIIO::TypeDesc::FLOAT);
  spec.channelnames = {"Z"};
  spec.z_channel = 0;
  // Row order; its columns are right, down, forward and the origin, as in PictureView.
  std::array<float, 16> matrix{};
  for (std::size_t row = 0; row < 3; ++row) {
    std::size_t column = 0;
    for (const auto* axis : {&view.right, &view.down, &view.forward, &view.origin_mm})
      matrix[4 * row + column++] = static_cast<float>((*axis)[row]);
  }
  matrix[15] = 1;
  spec.attribute("fanlight:camera", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 16), matrix.data());
  spec.attribute("fanlight:projection", view.mm_per_pixel_per_mm > 0 ? "perspective" : "parallel");
  spec.attribute("fanlight:mm_per_pixel", static_cast<float>(view.mm_per_pixel));
  spec.attribute("fanlight:mm_per_pixel_per_mm", static_cast<float>(view.mm_per_pixel_per_mm));
  spec.attribute("fanlight:middle_column", static_cast<float>(view.middle_column));
  spec.attribute("fanlight:middle_row", static_cast<float>(view.middle_row));
  spec.attribute(
      "fanlight:point",
      "origin + Z * forward + (mm_per_pixel + Z * mm_per_pixel_per_mm) * ((column - middle_column) * "
      "right + (row - middle_row) * down), mm");
  spec.attribute("compression", "zip");
  spec.attribute("DateTime", kNoTime);
  return write(path, spec, OIIO::TypeDesc::FLOAT, depth_mm.data(), OIIO::AutoStride, access);
}

}  // namespace fanlight
