// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "proto/base/file_replacement.hpp"
#include "proto/base/result.hpp"
#include "proto/model/picture.hpp"

namespace fanlight {

/// This name stands for the standard output, which gets a picture as PNG.
inline constexpr std::string_view kStandardOutput = "-";

/// Refuses a name that write_picture() could not write: one with an ending of no picture format, or in a
/// folder that is not there or may not be written. Before work is done that would be lost.
Result<void> check_picture_path(const std::string& path);

/// Refuses a name with an ending of no picture format.
Result<void> check_picture_ending(const std::string& path);

/// Refuses a name in a folder that is not there or may not be written.
Result<void> check_folder_of(const std::string& path);

/// Writes the picture as 8 bit RGB in the format of the file name extension (.png, .tif, .jpg, ...), with the
/// notes about its source as its description. As with replace_file(), a file of this name is replaced whole,
/// and stays as it was where this fails.
Result<void> write_picture(const std::string& path, const Picture& picture,
                           std::span<const std::string> notes, const FileAccess& access = {});

/// Checks the file name for a depth map: it must end in .exr, or be empty for no depth map.
Result<void> check_depth_path(const std::string& path);

/// Writes a depth map (height x width, row major, in mm, -1 where there is no surface) as one channel of 32
/// bit floats named Z. Attributes: fanlight:camera, a matrix of 4 x 4 whose columns are right, down, forward
/// and the origin of `view`; fanlight:projection, "parallel" or "perspective"; the other fields of `view` by
/// their names; and fanlight:point, the formula of PictureView. Otherwise as write_picture(). The path must
/// pass check_depth_path().
Result<void> write_depth(const std::string& path, std::span<const float> depth_mm, std::uint32_t width,
                         std::uint32_t height, const PictureView& view, const FileAccess& access = {});

}  // namespace fanlight
