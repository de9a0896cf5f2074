#pragma once

#include <span>
#include <string>

#include "proto/picture.hpp"
#include "proto/result.hpp"

namespace fanlight {

/// Writes the picture in the format that the file's name ends in (.png, .tif, .jpg, ...), 8 bit RGB.
Result<void> write_picture(const std::string& path, const Picture& picture);

/// Whether a depth map can be written under that name: it ends in .exr, or is empty for none.
Result<void> check_depth_path(const std::string& path);

/// Writes a depth map, height x width mm, as one channel of 32 bit floats named Z; -1 where there is no
/// surface. See check_depth_path. The mm per pixel stand in the attribute fanlight:mm_per_pixel.
Result<void> write_depth(const std::string& path, std::span<const float> depth_mm, std::uint32_t width,
                         std::uint32_t height, double mm_per_pixel);

}  // namespace fanlight
