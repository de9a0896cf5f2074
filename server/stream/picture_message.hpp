// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "proto/fanlight.pb.h"
#include "proto/model/picture.hpp"

namespace fanlight {

/// Writes the description of a picture: all but its pixels and depths.
void describe(v1::Picture& message, const Picture& picture);

/// The depth map in the form of the message field Picture.depth: 16 bits a pixel, little endian, in units of
/// kDepthUnitMm, 65535 where there is no surface, compressed with zlib. Empty if the picture has no depths.
std::string packed_depth(const Picture& picture);
inline constexpr double kDepthUnitMm = 0.01;

/// The position of the surface at a pixel of the full-size picture. `surface` is false outside the picture
/// and where there is no surface.
v1::DepthReply::Point point_at(const Picture& picture, std::uint32_t column, std::uint32_t row);

}  // namespace fanlight
