// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vulkan/vulkan.h>

#include <cstdint>

namespace fanlight {

/// How shaders read and write buffers by index (shaders/buffer_access.h).
enum class BufferAccess : std::uint8_t {
  kTexels,   ///< texel buffers: lavapipe of Mesa 22 gathers them, and reads storage buffers lane by lane
  kStorage,  ///< storage buffers: lavapipe of Mesa 25 calls a function for each texel fetch
};

/// Volumes have millions of words. Vulkan promises 65 536 texels; drivers offer that, or over a hundred
/// million.
inline bool has_useful_texels(const VkPhysicalDeviceLimits& limits) {
  return limits.maxTexelBufferElements >= 1U << 26;
}

}  // namespace fanlight
