// SPDX-License-Identifier: Apache-2.0
#include "renderer/passes/descriptor_sets.hpp"

#include <algorithm>

#include "renderer/vulkan/vulkan_result.hpp"
#include "shaders/bindings.h"

namespace fanlight {

Result<DescriptorSets> DescriptorSets::create(const Gpu& gpu, const Pipelines& pipelines) {
  DescriptorSets made;
  constexpr std::uint32_t kSets = std::tuple_size_v<decltype(made.sets_)>;
  std::array<VkDescriptorPoolSize, 5> sizes = {{{VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 0},
                                                {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 0},
                                                {VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER, 0},
                                                {VK_DESCRIPTOR_TYPE_STORAGE_TEXEL_BUFFER, 0},
                                                {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 0}}};
  for (std::uint32_t binding = 0; binding < FANLIGHT_BINDINGS; ++binding) {
    const auto size =
        std::ranges::find(sizes, Pipelines::descriptor_type(gpu, binding), &VkDescriptorPoolSize::type);
    if (Pipelines::has_binding(gpu, binding)) size->descriptorCount += kSets;
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
  made.pool_ = DescriptorPoolHandle(gpu.device(), pool);

  std::array<VkDescriptorSetLayout, kSets> layouts{};
  layouts.fill(pipelines.set_layout());
  const VkDescriptorSetAllocateInfo set_info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                             .descriptorPool = pool,
                                             .descriptorSetCount = kSets,
                                             .pSetLayouts = layouts.data()};
  result = vkAllocateDescriptorSets(gpu.device(), &set_info, made.sets_.data());
  if (result != VK_SUCCESS) return vulkan_error("vkAllocateDescriptorSets", result);
  return made;
}

void DescriptorSets::write(const Gpu& gpu, std::uint32_t binding, const GpuBuffer& buffer) const {
  if (!Pipelines::has_binding(gpu, binding)) return;
  for (std::size_t set = 0; set < sets_.size(); ++set) {
    std::uint32_t swapped = binding;
    if (set == 1 && binding == FANLIGHT_BINDING_LIT) swapped = FANLIGHT_BINDING_DIFFUSED;
    if (set == 1 && binding == FANLIGHT_BINDING_DIFFUSED) swapped = FANLIGHT_BINDING_LIT;
    const VkDescriptorBufferInfo info{.buffer = buffer.get(), .range = VK_WHOLE_SIZE};
    const VkBufferView texels = buffer.texels();
    const VkWriteDescriptorSet write{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                     .dstSet = sets_[set],
                                     .dstBinding = swapped,
                                     .descriptorCount = 1,
                                     .descriptorType = Pipelines::descriptor_type(gpu, binding),
                                     .pBufferInfo = &info,
                                     .pTexelBufferView = &texels};
    vkUpdateDescriptorSets(gpu.device(), 1, &write, 0, nullptr);
  }
}

void DescriptorSets::write(const Gpu& gpu, std::uint32_t binding, const GpuImage& image) const {
  for (const VkDescriptorSet set : sets_) {
    const VkDescriptorImageInfo info{.imageView = image.view(),
                                     .imageLayout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    const VkWriteDescriptorSet write{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                     .dstSet = set,
                                     .dstBinding = binding,
                                     .descriptorCount = 1,
                                     .descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                                     .pImageInfo = &info};
    vkUpdateDescriptorSets(gpu.device(), 1, &write, 0, nullptr);
  }
}

void DescriptorSets::bind(VkCommandBuffer commands, const Pipelines& pipelines, Order order) const {
  vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipelines.layout(), 0, 1,
                          &sets_[static_cast<std::size_t>(order)], 0, nullptr);
}

}  // namespace fanlight
