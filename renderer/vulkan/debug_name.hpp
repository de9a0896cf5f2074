// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>

#include "renderer/vulkan/gpu.hpp"

namespace fanlight {

// Names of Vulkan objects, for the messages of the validation layers and for debugging tools. They do nothing
// where VK_EXT_debug_utils is missing. The name is copied by the driver.

inline void set_debug_name(const Gpu& gpu, VkBuffer buffer, const char* name) {
  gpu.set_debug_name(VK_OBJECT_TYPE_BUFFER, std::bit_cast<std::uint64_t>(buffer), name);
}
inline void set_debug_name(const Gpu& gpu, VkImage image, const char* name) {
  gpu.set_debug_name(VK_OBJECT_TYPE_IMAGE, std::bit_cast<std::uint64_t>(image), name);
}
inline void set_debug_name(const Gpu& gpu, VkPipeline pipeline, const char* name) {
  gpu.set_debug_name(VK_OBJECT_TYPE_PIPELINE, std::bit_cast<std::uint64_t>(pipeline), name);
}
inline void set_debug_name(const Gpu& gpu, VkSemaphore semaphore, const char* name) {
  gpu.set_debug_name(VK_OBJECT_TYPE_SEMAPHORE, std::bit_cast<std::uint64_t>(semaphore), name);
}
inline void set_debug_name(const Gpu& gpu, VkCommandBuffer commands, const char* name) {
  gpu.set_debug_name(VK_OBJECT_TYPE_COMMAND_BUFFER, std::bit_cast<std::uint64_t>(commands), name);
}
inline void set_debug_name(const Gpu& gpu, VkQueue queue, const char* name) {
  gpu.set_debug_name(VK_OBJECT_TYPE_QUEUE, std::bit_cast<std::uint64_t>(queue), name);
}

}  // namespace fanlight
