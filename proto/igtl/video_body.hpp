// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "proto/igtl/image_body.hpp"

namespace fanlight::igtl {

/// How a picture of a VIDEO was encoded; the numbers are those that OpenIGTLink's own encoders write.
enum class VideoFrame : std::uint16_t {
  kKey = 1,        ///< can be decoded without the pictures before it
  kPredicted = 3,  ///< from the picture before it
};

inline constexpr std::size_t kVideoHeaderBytes = 76;

/// Appends the header of a VIDEO's content for H.264 (igtl_frame_header of OpenIGTLink 3). The encoded
/// picture follows it. Debian's library has no VIDEO, so the layout is ours.
void put_video_header(std::vector<std::uint8_t>& bytes, const std::array<std::uint16_t, 3>& size,
                      const GridPose& pose, VideoFrame frame);

}  // namespace fanlight::igtl
