#pragma once

#include <string>

#include "proto/fanlight.pb.h"
#include "proto/picture.hpp"

namespace fanlight {

/// All of a picture but its pixels.
void describe(v1::Picture& message, const Picture& picture);

/// Its depth map as Picture.depth has it: 16 bits a pixel, in hundredths of a millimetre, through zlib. Empty
/// where the picture has none.
std::string packed_depth(const Picture& picture);
inline constexpr double kDepthUnitMm = 0.01;

/// Where the surface lies at a pixel of the full size; `surface` false outside the picture and where there is
/// none.
v1::DepthReply::Point point_at(const Picture& picture, std::uint32_t column, std::uint32_t row);

}  // namespace fanlight
