// SPDX-License-Identifier: Apache-2.0
#include "renderer/vulkan/command_recording.hpp"

#include "renderer/vulkan/vulkan_result.hpp"

namespace fanlight {

namespace {

void image_barrier(VkCommandBuffer commands, VkImage image, VkImageLayout from, VkImageLayout to) {
  const bool before_copy = to == VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
  const VkImageMemoryBarrier2 change{
      .sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
      .srcStageMask = before_copy ? VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT : VK_PIPELINE_STAGE_2_COPY_BIT,
      .srcAccessMask = before_copy ? VK_ACCESS_2_NONE : VK_ACCESS_2_TRANSFER_WRITE_BIT,
      .dstStageMask = before_copy ? VK_PIPELINE_STAGE_2_COPY_BIT : VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
      .dstAccessMask = before_copy ? VK_ACCESS_2_TRANSFER_WRITE_BIT : VK_ACCESS_2_SHADER_SAMPLED_READ_BIT,
      .oldLayout = from,
      .newLayout = to,
      .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
      .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
      .image = image,
      .subresourceRange = {.aspectMask = VK_IMAGE_ASPECT_COLOR_BIT, .levelCount = 1, .layerCount = 1}};
  const VkDependencyInfo dependency{.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
                                    .imageMemoryBarrierCount = 1,
                                    .pImageMemoryBarriers = &change};
  vkCmdPipelineBarrier2(commands, &dependency);
}

}  // namespace

Result<void> begin_commands(VkCommandBuffer commands) {
  const VkCommandBufferBeginInfo info{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                      .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
  const VkResult result = vkBeginCommandBuffer(commands, &info);
  if (result != VK_SUCCESS) return vulkan_error("vkBeginCommandBuffer", result);
  return {};
}

void barrier(VkCommandBuffer commands, VkPipelineStageFlags2 from_stage, VkAccessFlags2 from_access,
             VkPipelineStageFlags2 to_stage, VkAccessFlags2 to_access) {
  const VkMemoryBarrier2 memory{.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
                                .srcStageMask = from_stage,
                                .srcAccessMask = from_access,
                                .dstStageMask = to_stage,
                                .dstAccessMask = to_access};
  const VkDependencyInfo dependency{
      .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .memoryBarrierCount = 1, .pMemoryBarriers = &memory};
  vkCmdPipelineBarrier2(commands, &dependency);
}

void pass_barrier(VkCommandBuffer commands) {
  barrier(commands, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
          VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
          VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_SAMPLED_READ_BIT);
}

void host_barrier(VkCommandBuffer commands) {
  barrier(commands, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
          VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT | VK_ACCESS_2_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_2_HOST_BIT,
          VK_ACCESS_2_HOST_READ_BIT | VK_ACCESS_2_HOST_WRITE_BIT);
}

void copy_to_image(VkCommandBuffer commands, const GpuBuffer& from, const GpuImage& to,
                   const SliceCopy& copy) {
  image_barrier(commands, to.get(),
                copy.keeps_others ? VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL : VK_IMAGE_LAYOUT_UNDEFINED,
                VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
  const VkBufferImageCopy slices{
      .bufferOffset = std::uint64_t{copy.row_texels} * to.extent().height * copy.first_slice,
      .bufferRowLength = copy.row_texels,
      .imageSubresource = {.aspectMask = VK_IMAGE_ASPECT_COLOR_BIT, .layerCount = 1},
      .imageOffset = {.z = static_cast<std::int32_t>(copy.first_slice)},
      .imageExtent = {to.extent().width, to.extent().height, copy.slices}};
  vkCmdCopyBufferToImage(commands, from.get(), to.get(), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &slices);
  image_barrier(commands, to.get(), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
  // The next shader may write to the buffer.
  barrier(commands, VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_NONE, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
          VK_ACCESS_2_NONE);
}

}  // namespace fanlight
