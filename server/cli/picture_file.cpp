// SPDX-License-Identifier: Apache-2.0
#include "server/cli/picture_file.hpp"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "proto/base/file_replacement.hpp"

namespace fanlight {

namespace {

Error unwritable(const std::string& path, std::string reason) {
  while (!reason.empty() && (reason.back() == '\n' || reason.back() == '.')) reason.pop_back();
  return {ErrorCode::kUnavailable, fmt::format("{} could not be written ({}), expected a name that ends in a "
                                               "picture format such as .png or .exr",
                                               path, reason)};
}

/// Encodes in memory: the library reports no error of a full disk where it writes to a file itself.
Result<void> write(const std::string& path, const OIIO::ImageSpec& spec, const OIIO::TypeDesc& type,
                   const void* pixels, OIIO::stride_t pixel_stride) {
  const auto output = OIIO::ImageOutput::create(path);
  if (!output) return unwritable(path, OIIO::geterror());
  OIIO::Filesystem::IOVecOutput encoded;
  if (!output->supports("ioproxy") || !output->set_ioproxy(&encoded)) {
    return unwritable(path, fmt::format("the format {} is not supported", output->format_name()));
  }
  if (!output->open(path, spec) || !output->write_image(type, pixels, pixel_stride) || !output->close()) {
    return unwritable(path, output->geterror());
  }
  const auto& bytes = encoded.buffer();
  return replace_file(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace

Result<void> write_picture(const std::string& path, const Picture& picture,
                           std::span<const std::string> notes) {
  OIIO::ImageSpec spec(static_cast<int>(picture.width), static_cast<int>(picture.height), 3,
                       OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:ColorSpace", "sRGB");
  if (!notes.empty()) spec.attribute("ImageDescription", fmt::format("{}", fmt::join(notes, " ")));
  return write(path, spec, OIIO::TypeDesc::UINT8, picture.rgba.data(), 4);
}

Result<void> check_depth_path(const std::string& path) {
  if (path.empty() || path.ends_with(".exr")) return {};
  return unwritable(path, "depth needs 32 bit floats, which only .exr is asked to hold");
}

Result<void> write_depth(const std::string& path, std::span<const float> depth_mm, std::uint32_t width,
                         std::uint32_t height, double mm_per_pixel) {
  OIIO::ImageSpec spec(static_cast<int>(width), static_cast<int>(height), 1, OIIO::TypeDesc::FLOAT);
  spec.channelnames = {"Z"};
  spec.z_channel = 0;
  spec.attribute("fanlight:mm_per_pixel", static_cast<float>(mm_per_pixel));
  spec.attribute("compression", "zip");
  return write(path, spec, OIIO::TypeDesc::FLOAT, depth_mm.data(), OIIO::AutoStride);
}

}  // namespace fanlight
