// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vulkan/vulkan.h>

#include <cstdint>

#include "renderer/vulkan/gpu_memory.hpp"

namespace fanlight {

/// Number of groups of `of` items that cover all items.
constexpr std::uint32_t groups(std::uint32_t items, std::uint32_t of) {
  return (items + of - 1) / of;
}

/// Begins a command buffer for a single submission.
Result<void> begin_commands(VkCommandBuffer commands);

/// Makes writes of the first stage visible to the second stage.
void barrier(VkCommandBuffer commands, VkPipelineStageFlags2 from_stage, VkAccessFlags2 from_access,
             VkPipelineStageFlags2 to_stage, VkAccessFlags2 to_access);

/// Makes writes of a compute shader visible to the next one.
void pass_barrier(VkCommandBuffer commands);

/// Makes writes of compute shaders and copies visible to the processor, which may write there itself.
void host_barrier(VkCommandBuffer commands);

/// Some slices of a texture, to be copied from a buffer that holds all of them.
struct SliceCopy {
  std::uint32_t row_texels = 0;  ///< row pitch in the buffer
  std::uint32_t first_slice = 0;
  std::uint32_t slices = 1;
  bool keeps_others = false;  ///< keeps the contents of the other slices
};

/// Replaces slices of a texture with one byte per texel, or the only slice of a texture of any format.
/// Shaders may read the texture afterwards.
void copy_to_image(VkCommandBuffer commands, const GpuBuffer& from, const GpuImage& to,
                   const SliceCopy& copy);

}  // namespace fanlight
