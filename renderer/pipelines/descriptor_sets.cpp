// SPDX-License-Identifier: Apache-2.0
#include "renderer/pipelines/descriptor_sets.hpp"

#include <algorithm>
#include <utility>

#include "renderer/vulkan/shader_interface.hpp"
#include "renderer/vulkan/vulkan_result.hpp"
#include "shaders/bindings.h"

namespace fanlight {

Result<DescriptorSets> DescriptorSets::create(const PassDevice& device) {
  DescriptorSets made;
  made.device_ = device;
  if (auto sets = made.create_sets(); !sets) return sets.error();
  if (auto placeholders = made.create_placeholders(); !placeholders) return placeholders.error();
  return made;
}

Result<void> DescriptorSets::create_sets() {
  const Gpu& gpu = *device_.gpu;
  constexpr std::uint32_t kSets = std::tuple_size_v<decltype(sets_)>;
  std::array<VkDescriptorPoolSize, 5> sizes = {{{VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 0},
                                                {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 0},
                                                {VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER, 0},
                                                {VK_DESCRIPTOR_TYPE_STORAGE_TEXEL_BUFFER, 0},
                                                {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 0}}};
  for (const auto& type : binding_types(gpu.buffer_access())) {
    if (type) std::ranges::find(sizes, *type, &VkDescriptorPoolSize::type)->descriptorCount += kSets;
  }
  // Vulkan takes no pool of none: texel buffers may have no binding.
  const auto used = std::ranges::partition(sizes, [](const VkDescriptorPoolSize& size) {
                      return size.descriptorCount > 0;
                    }).begin();
  const VkDescriptorPoolCreateInfo pool_info{
      .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
      .maxSets = kSets,
      .poolSizeCount = static_cast<std::uint32_t>(used - sizes.begin()),
      .pPoolSizes = sizes.data()};
  VkDescriptorPool pool = VK_NULL_HANDLE;
  VkResult result = vkCreateDescriptorPool(gpu.device(), &pool_info, nullptr, &pool);
  if (result != VK_SUCCESS) return vulkan_error("vkCreateDescriptorPool", result);
  pool_ = DescriptorPoolHandle(gpu.device(), pool);

  std::array<VkDescriptorSetLayout, kSets> layouts{};
  layouts.fill(device_.pipelines->set_layout());
  const VkDescriptorSetAllocateInfo set_info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                             .descriptorPool = pool,
                                             .descriptorSetCount = kSets,
                                             .pSetLayouts = layouts.data()};
  result = vkAllocateDescriptorSets(gpu.device(), &set_info, sets_.data());
  if (result != VK_SUCCESS) return vulkan_error("vkAllocateDescriptorSets", result);
  return {};
}

Result<void> DescriptorSets::create_placeholders() {
  auto buffer =
      GpuBuffer::create(*device_.gpu, "no buffer", sizeof(std::uint32_t),
                        VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT | VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT |
                            VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_STORAGE_TEXEL_BUFFER_BIT,
                        BufferPlace::kDevice, VK_FORMAT_R32_UINT);
  if (!buffer) return buffer.error();
  no_buffer_ = std::move(*buffer);
  auto image = GpuImage::create(*device_.gpu, "no image", VK_FORMAT_R32G32B32A32_SFLOAT, {1, 1, 1});
  if (!image) return image.error();
  no_image_ = std::move(*image);
  const BindingTypes& types = binding_types(device_.gpu->buffer_access());
  for (std::uint32_t binding = 0; binding < types.size(); ++binding) {
    if (types[binding] == VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER) {
      write(binding, no_image_);
    } else {
      write(binding, no_buffer_);
    }
  }
  return {};
}

void DescriptorSets::write(std::uint32_t binding, const GpuBuffer& buffer) const {
  const Gpu& gpu = *device_.gpu;
  // Storage buffers have one binding for both reading and writing.
  const auto type = binding_types(gpu.buffer_access()).at(binding);
  if (!type) return;
  const GpuBuffer& named = buffer.bytes() > 0 ? buffer : no_buffer_;
  for (std::size_t set = 0; set < sets_.size(); ++set) {
    std::uint32_t swapped = binding;
    if (set == 1 && binding == FANLIGHT_BINDING_LIT) swapped = FANLIGHT_BINDING_DIFFUSED;
    if (set == 1 && binding == FANLIGHT_BINDING_DIFFUSED) swapped = FANLIGHT_BINDING_LIT;
    const VkDescriptorBufferInfo info{.buffer = named.get(), .range = VK_WHOLE_SIZE};
    const VkBufferView texels = named.texels();
    const VkWriteDescriptorSet write{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                     .dstSet = sets_[set],
                                     .dstBinding = swapped,
                                     .descriptorCount = 1,
                                     .descriptorType = *type,
                                     .pBufferInfo = &info,
                                     .pTexelBufferView = &texels};
    vkUpdateDescriptorSets(gpu.device(), 1, &write, 0, nullptr);
  }
}

void DescriptorSets::write(std::uint32_t binding, const GpuImage& image) const {
  const GpuImage& named = image.get() != VK_NULL_HANDLE ? image : no_image_;
  for (const VkDescriptorSet set : sets_) {
    const VkDescriptorImageInfo info{.imageView = named.view(),
                                     .imageLayout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    const VkWriteDescriptorSet write{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                     .dstSet = set,
                                     .dstBinding = binding,
                                     .descriptorCount = 1,
                                     .descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                                     .pImageInfo = &info};
    vkUpdateDescriptorSets(device_.gpu->device(), 1, &write, 0, nullptr);
  }
}

void DescriptorSets::bind(VkCommandBuffer commands, Order order) const {
  vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, device_.pipelines->layout(), 0, 1,
                          &sets_[static_cast<std::size_t>(order)], 0, nullptr);
}

}  // namespace fanlight
