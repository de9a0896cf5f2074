// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "proto/igtl/image_body.hpp"
#include "proto/igtl/message_head.hpp"

namespace fanlight::igtl {

/// A TRANSFORM has the columns of a 3 x 4 matrix: three axes and a place, mm. As GridPose: the axes of a
/// frame of reference, and its origin.
inline constexpr std::size_t kTransformBytes = 48;

/// nullopt: another length, or a value that is no number.
std::optional<GridPose> parse_transform(std::span<const std::uint8_t> content);
void put_transform(std::vector<std::uint8_t>& bytes, const GridPose& pose);

/// One instrument of a TDATA message.
struct TrackedTool {
  DeviceName name;
  GridPose pose;
};
inline constexpr std::size_t kToolBytes = 70;
/// Of a TDATA message; an incomplete one at the end does not count.
inline std::size_t tool_count(std::span<const std::uint8_t> content) {
  return content.size() / kToolBytes;
}
/// nullopt: a value that is no number. Precondition: index < tool_count().
std::optional<TrackedTool> parse_tool(std::span<const std::uint8_t> content, std::size_t index);

/// Content of STT_TDATA: the least time between two messages, and the frame of reference, empty for the usual
/// one.
void put_start_of_tools(std::vector<std::uint8_t>& bytes, std::uint32_t least_ms);

/// `outer` after `inner`: what `inner` places in a frame of reference whose pose is `outer`.
GridPose composed(const GridPose& outer, const GridPose& inner);

}  // namespace fanlight::igtl
