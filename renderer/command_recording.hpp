#pragma once

#include <vulkan/vulkan.h>

#include <cstdint>

#include "renderer/gpu_memory.hpp"

namespace fanlight {

constexpr std::uint32_t groups(std::uint32_t items, std::uint32_t of) {
  return (items + of - 1) / of;
}

/// What was written in the first stage is there for the second.
void barrier(VkCommandBuffer commands, VkPipelineStageFlags2 from_stage, VkAccessFlags2 from_access,
             VkPipelineStageFlags2 to_stage, VkAccessFlags2 to_access);

/// Between two shaders, the second of which reads what the first wrote.
void pass_barrier(VkCommandBuffer commands);

/// Replaces the first `slices` of a texture; shaders may read it afterwards. `row_texels`: from one row to
/// the next in the buffer.
void copy_to_image(VkCommandBuffer commands, const GpuBuffer& from, const GpuImage& to,
                   std::uint32_t row_texels, std::uint32_t slices);

}  // namespace fanlight
