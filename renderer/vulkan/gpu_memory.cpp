// SPDX-License-Identifier: Apache-2.0
#include "renderer/vulkan/gpu_memory.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "renderer/vulkan/debug_name.hpp"
#include "renderer/vulkan/vulkan_result.hpp"

namespace fanlight {

namespace {

// Vulkan forbids requests beyond these limits; a driver need not refuse them.
Error exceeds(std::uint64_t most_bytes, std::uint64_t bytes) {
  return {ErrorCode::kUnavailable,
          fmt::format("{} bytes of GPU memory were requested, expected at most {}", bytes, most_bytes)};
}

Result<MemoryHandle> allocate(const Gpu& gpu, const VkMemoryRequirements& needs, VkMemoryPropertyFlags wanted,
                              VkMemoryPropertyFlags preferred) {
  const auto type = gpu.memory_type(needs.memoryTypeBits, wanted, preferred);
  if (!type) return type.error();
  const std::uint64_t most_bytes = std::min(gpu.heap_bytes(*type), gpu.largest_allocation_bytes());
  if (needs.size > most_bytes) return exceeds(most_bytes, needs.size);
  const VkMemoryAllocateInfo info{.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                  .allocationSize = needs.size,
                                  .memoryTypeIndex = *type};
  VkDeviceMemory memory = VK_NULL_HANDLE;
  const VkResult result = vkAllocateMemory(gpu.device(), &info, nullptr, &memory);
  if (result != VK_SUCCESS) return vulkan_error("vkAllocateMemory", result);
  return MemoryHandle(gpu.device(), memory);
}

}  // namespace

Result<GpuBuffer> GpuBuffer::create(const Gpu& gpu, const char* name, std::uint64_t bytes,
                                    VkBufferUsageFlags usage, BufferPlace place, VkFormat texels) {
  if (bytes > gpu.largest_buffer_bytes()) return exceeds(gpu.largest_buffer_bytes(), bytes);
  constexpr VkBufferUsageFlags kTexelUsages =
      VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT | VK_BUFFER_USAGE_STORAGE_TEXEL_BUFFER_BIT;
  if (gpu.buffer_access() == BufferAccess::kStorage && texels != VK_FORMAT_UNDEFINED) {
    usage = (usage & ~kTexelUsages) | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
    texels = VK_FORMAT_UNDEFINED;
  }
  if (texels != VK_FORMAT_UNDEFINED) {
    constexpr std::uint64_t kTexelBytes = 4;  // of every format in use
    const std::uint64_t most_bytes = kTexelBytes * gpu.limits().maxTexelBufferElements;
    if (bytes > most_bytes) return exceeds(most_bytes, bytes);
  }
  GpuBuffer made;
  made.bytes_ = bytes;
  const VkBufferCreateInfo info{.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = bytes, .usage = usage};
  VkBuffer buffer = VK_NULL_HANDLE;
  VkResult result = vkCreateBuffer(gpu.device(), &info, nullptr, &buffer);
  if (result != VK_SUCCESS) return vulkan_error("vkCreateBuffer", result);
  made.buffer_ = BufferHandle(gpu.device(), buffer);
  set_debug_name(gpu, buffer, name);

  constexpr VkMemoryPropertyFlags kMapped =
      VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  VkMemoryRequirements needs{};
  vkGetBufferMemoryRequirements(gpu.device(), buffer, &needs);
  auto memory = place == BufferPlace::kDevice ? allocate(gpu, needs, 0, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT)
                : place == BufferPlace::kToGpu
                    ? allocate(gpu, needs, kMapped, 0)
                    : allocate(gpu, needs, kMapped, VK_MEMORY_PROPERTY_HOST_CACHED_BIT);
  if (!memory) return memory.error();
  made.memory_ = std::move(*memory);
  result = vkBindBufferMemory(gpu.device(), buffer, made.memory_.get(), 0);
  if (result != VK_SUCCESS) return vulkan_error("vkBindBufferMemory", result);

  if (texels != VK_FORMAT_UNDEFINED) {
    const VkBufferViewCreateInfo view_info{.sType = VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO,
                                           .buffer = buffer,
                                           .format = texels,
                                           .range = VK_WHOLE_SIZE};
    VkBufferView view = VK_NULL_HANDLE;
    result = vkCreateBufferView(gpu.device(), &view_info, nullptr, &view);
    if (result != VK_SUCCESS) return vulkan_error("vkCreateBufferView", result);
    made.view_ = BufferViewHandle(gpu.device(), view);
  }

  if (place != BufferPlace::kDevice) {
    void* mapped = nullptr;
    result = vkMapMemory(gpu.device(), made.memory_.get(), 0, VK_WHOLE_SIZE, 0, &mapped);
    if (result != VK_SUCCESS) return vulkan_error("vkMapMemory", result);
    made.mapped_ = static_cast<std::uint8_t*>(mapped);
  }
  return made;
}

Result<void> create_buffers(const Gpu& gpu, std::span<const WantedBuffer> wanted) {
  for (const WantedBuffer& each : wanted) {
    auto buffer = GpuBuffer::create(gpu, each.name, each.bytes, each.usage, each.place);
    if (!buffer) return buffer.error();
    *each.buffer = std::move(*buffer);
  }
  return {};
}

Result<GpuImage> GpuImage::create(const Gpu& gpu, const char* name, VkFormat format, VkExtent3D extent) {
  GpuImage made;
  made.extent_ = extent;
  struct Dimensions {
    VkImageType image;
    VkImageViewType view;
  };
  const Dimensions dimensions = extent.depth > 1    ? Dimensions{VK_IMAGE_TYPE_3D, VK_IMAGE_VIEW_TYPE_3D}
                                : extent.height > 1 ? Dimensions{VK_IMAGE_TYPE_2D, VK_IMAGE_VIEW_TYPE_2D}
                                                    : Dimensions{VK_IMAGE_TYPE_1D, VK_IMAGE_VIEW_TYPE_1D};
  const VkImageCreateInfo info{.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                               .imageType = dimensions.image,
                               .format = format,
                               .extent = extent,
                               .mipLevels = 1,
                               .arrayLayers = 1,
                               .samples = VK_SAMPLE_COUNT_1_BIT,
                               .tiling = VK_IMAGE_TILING_OPTIMAL,
                               .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT};
  VkImage image = VK_NULL_HANDLE;
  VkResult result = vkCreateImage(gpu.device(), &info, nullptr, &image);
  if (result != VK_SUCCESS) return vulkan_error("vkCreateImage", result);
  made.image_ = ImageHandle(gpu.device(), image);
  set_debug_name(gpu, image, name);

  VkMemoryRequirements needs{};
  vkGetImageMemoryRequirements(gpu.device(), image, &needs);
  auto memory = allocate(gpu, needs, 0, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
  if (!memory) return memory.error();
  made.memory_ = std::move(*memory);
  result = vkBindImageMemory(gpu.device(), image, made.memory_.get(), 0);
  if (result != VK_SUCCESS) return vulkan_error("vkBindImageMemory", result);

  const VkImageViewCreateInfo view_info{
      .sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
      .image = image,
      .viewType = dimensions.view,
      .format = format,
      .subresourceRange = {.aspectMask = VK_IMAGE_ASPECT_COLOR_BIT, .levelCount = 1, .layerCount = 1}};
  VkImageView view = VK_NULL_HANDLE;
  result = vkCreateImageView(gpu.device(), &view_info, nullptr, &view);
  if (result != VK_SUCCESS) return vulkan_error("vkCreateImageView", result);
  made.view_ = ImageViewHandle(gpu.device(), view);
  return made;
}

}  // namespace fanlight
