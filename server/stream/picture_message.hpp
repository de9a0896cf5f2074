// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

#include "proto/fanlight.pb.h"
#include "proto/model/picture.hpp"
#include "proto/model/picture_size.hpp"

namespace fanlight {

/// Writes the description of a picture: all but its pixels and depths.
void describe(v1::Picture& message, const Picture& picture);

/// Writes the position of a picture's pixels.
void describe(v1::View& message, const PictureView& view);

/// A depth map (Picture::depth_mm) in the form of the message field Picture.depth: 16 bits a pixel, little
/// endian, in units of kDepthUnitMm, 65535 where there is no surface, compressed with zlib. Empty if there
/// are no depths.
std::string packed_depth(std::span<const float> depths_mm);
inline constexpr double kDepthUnitMm = 0.01;

/// The position of the surface at a pixel. Pixels count as if the picture had the size `counted`. `surface`
/// is false outside the picture and where there is no surface.
v1::DepthReply::Point point_at(const Picture& picture, PictureSize counted, std::uint32_t counted_column,
                               std::uint32_t counted_row);

}  // namespace fanlight
