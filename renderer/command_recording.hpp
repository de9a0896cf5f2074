#pragma once

#include <vulkan/vulkan.h>

#include <cstdint>

#include "renderer/gpu_memory.hpp"

namespace fanlight {

constexpr std::uint32_t groups(std::uint32_t items, std::uint32_t of) {
  return (items + of - 1) / of;
}

/// Begins a command buffer that is submitted once.
Result<void> begin_commands(VkCommandBuffer commands);

/// What was written in the first stage is there for the second.
void barrier(VkCommandBuffer commands, VkPipelineStageFlags2 from_stage, VkAccessFlags2 from_access,
             VkPipelineStageFlags2 to_stage, VkAccessFlags2 to_access);

/// Between two shaders, the second of which reads what the first wrote.
void pass_barrier(VkCommandBuffer commands);

/// Some slices of a texture, from a buffer that holds all of them.
struct SliceCopy {
  std::uint32_t row_texels = 0;  ///< from one row to the next in the buffer
  std::uint32_t first_slice = 0;
  std::uint32_t slices = 1;
  bool keeps_others = false;  ///< what is in the other slices stays
};

/// Replaces slices of a texture of a byte a texel, or the only slice of any; shaders may read it afterwards.
void copy_to_image(VkCommandBuffer commands, const GpuBuffer& from, const GpuImage& to,
                   const SliceCopy& copy);

}  // namespace fanlight
