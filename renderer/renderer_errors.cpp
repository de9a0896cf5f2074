// SPDX-License-Identifier: Apache-2.0
#include "renderer/renderer_errors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <glm/vec2.hpp>

namespace fanlight {

Result<void> check_sizes(PictureSize usual, PictureSize largest, const VkPhysicalDeviceLimits& limits) {
  // The largest map has two words a pixel.
  const std::uint32_t most_pixels = limits.maxStorageBufferRange / sizeof(glm::uvec2);
  for (const PictureSize& size : {usual, largest}) {
    if (std::min(size.width, size.height) >= 2 && size.pixels() <= most_pixels) continue;
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("a picture of {} x {} does not fit this GPU, expected 2 x 2 to {} pixels",
                             size.width, size.height, most_pixels)};
  }
  return {};
}

Error too_large(const Error& error, const std::string& gpu, std::uint64_t volume_bytes) {
  if (error.code != ErrorCode::kUnavailable) return error;
  return {error.code,
          fmt::format("{} has no memory for two volumes of {:.2f} GB, each there and on its way ({}), "
                      "expected smaller ones",
                      gpu, static_cast<double>(volume_bytes) / 1e9, error.message)};
}

bool is_breakage(const Error& error) {
  return error.code == ErrorCode::kBroken || error.code == ErrorCode::kLost;
}

Result<void> as_breakage(Result<void> done) {
  if (done || is_breakage(done.error())) return done;
  return Error{ErrorCode::kBroken, done.error().message};
}

Error not_finished_for(std::int64_t time_ns) {
  return {ErrorCode::kLost, fmt::format("the GPU has not finished a submission for {:.0f} s, expected it "
                                        "within a few times the longest before",
                                        static_cast<double>(time_ns) / 1e9)};
}

}  // namespace fanlight
