// SPDX-License-Identifier: Apache-2.0
#include "renderer/vulkan/access_trial.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "proto/base/clock.hpp"
#include "renderer/vulkan/command_recording.hpp"
#include "renderer/vulkan/gpu_memory.hpp"
#include "renderer/vulkan/vulkan_result.hpp"
#include "shaders/spirv.hpp"

namespace fanlight {

namespace {

constexpr std::uint32_t kGroups = 64;
constexpr std::uint32_t kGroupSize = 64;
constexpr std::uint64_t kWords =
    131 * 131;  // all that the shader reads, and less than the smallest texel buffer
constexpr int kRounds = 5;

/// One way of reading, ready to run.
class Way {
 public:
  static Result<Way> create(const Gpu& gpu, BufferAccess access, const GpuBuffer& words,
                            const GpuBuffer& sums);

  /// Runs it once and blocks. Returns how long it took, ms.
  Result<double> run(VkQueue queue) const;

 private:
  Result<void> create_layout(const Gpu& gpu, VkDescriptorType reads);
  Result<void> create_set(const Gpu& gpu, VkDescriptorType reads, const GpuBuffer& words,
                          const GpuBuffer& sums);
  Result<void> create_pipeline(const Gpu& gpu, std::span<const std::uint32_t> spirv);
  Result<void> record(const Gpu& gpu);

  DescriptorSetLayoutHandle set_layout_;
  PipelineLayoutHandle layout_;
  DescriptorPoolHandle pool_;
  PipelineHandle pipeline_;
  CommandPoolHandle command_pool_;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
};

Result<Way> Way::create(const Gpu& gpu, BufferAccess access, const GpuBuffer& words, const GpuBuffer& sums) {
  const bool texels = access == BufferAccess::kTexels;
  const VkDescriptorType reads =
      texels ? VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER : VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
  Way made;
  if (auto step = made.create_layout(gpu, reads); !step) return step.error();
  if (auto step = made.create_set(gpu, reads, words, sums); !step) return step.error();
  const auto spirv = texels ? shaders::access_trial_spirv : shaders::access_trial_storage_spirv;
  if (auto step = made.create_pipeline(gpu, spirv); !step) return step.error();
  if (auto step = made.record(gpu); !step) return step.error();
  return made;
}

Result<void> Way::create_layout(const Gpu& gpu, VkDescriptorType reads) {
  const std::array<VkDescriptorSetLayoutBinding, 2> bindings = {
      {{.binding = 0,
        .descriptorType = reads,
        .descriptorCount = 1,
        .stageFlags = VK_SHADER_STAGE_COMPUTE_BIT},
       {.binding = 1,
        .descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
        .descriptorCount = 1,
        .stageFlags = VK_SHADER_STAGE_COMPUTE_BIT}}};
  const VkDescriptorSetLayoutCreateInfo set_info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                                 .bindingCount = bindings.size(),
                                                 .pBindings = bindings.data()};
  VkDescriptorSetLayout set_layout = VK_NULL_HANDLE;
  VkResult result = vkCreateDescriptorSetLayout(gpu.device(), &set_info, nullptr, &set_layout);
  if (result != VK_SUCCESS) return vulkan_error("vkCreateDescriptorSetLayout", result);
  set_layout_ = DescriptorSetLayoutHandle(gpu.device(), set_layout);
  const VkPipelineLayoutCreateInfo info{.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                        .setLayoutCount = 1,
                                        .pSetLayouts = &set_layout};
  VkPipelineLayout layout = VK_NULL_HANDLE;
  result = vkCreatePipelineLayout(gpu.device(), &info, nullptr, &layout);
  if (result != VK_SUCCESS) return vulkan_error("vkCreatePipelineLayout", result);
  layout_ = PipelineLayoutHandle(gpu.device(), layout);
  return {};
}

Result<void> Way::create_set(const Gpu& gpu, VkDescriptorType reads, const GpuBuffer& words,
                             const GpuBuffer& sums) {
  const std::array<VkDescriptorPoolSize, 2> sizes = {
      {{.type = reads, .descriptorCount = 1},
       {.type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, .descriptorCount = 1}}};
  const VkDescriptorPoolCreateInfo pool_info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                             .maxSets = 1,
                                             .poolSizeCount = sizes.size(),
                                             .pPoolSizes = sizes.data()};
  VkDescriptorPool pool = VK_NULL_HANDLE;
  VkResult result = vkCreateDescriptorPool(gpu.device(), &pool_info, nullptr, &pool);
  if (result != VK_SUCCESS) return vulkan_error("vkCreateDescriptorPool", result);
  pool_ = DescriptorPoolHandle(gpu.device(), pool);
  const VkDescriptorSetLayout set_layout = set_layout_.get();
  const VkDescriptorSetAllocateInfo set_info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                             .descriptorPool = pool,
                                             .descriptorSetCount = 1,
                                             .pSetLayouts = &set_layout};
  result = vkAllocateDescriptorSets(gpu.device(), &set_info, &set_);
  if (result != VK_SUCCESS) return vulkan_error("vkAllocateDescriptorSets", result);
  const VkDescriptorBufferInfo read{.buffer = words.get(), .range = VK_WHOLE_SIZE};
  const VkDescriptorBufferInfo written{.buffer = sums.get(), .range = VK_WHOLE_SIZE};
  const VkBufferView texels = words.texels();
  const std::array<VkWriteDescriptorSet, 2> writes = {{{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                                        .dstSet = set_,
                                                        .dstBinding = 0,
                                                        .descriptorCount = 1,
                                                        .descriptorType = reads,
                                                        .pBufferInfo = &read,
                                                        .pTexelBufferView = &texels},
                                                       {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                                        .dstSet = set_,
                                                        .dstBinding = 1,
                                                        .descriptorCount = 1,
                                                        .descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                                                        .pBufferInfo = &written}}};
  vkUpdateDescriptorSets(gpu.device(), writes.size(), writes.data(), 0, nullptr);
  return {};
}

Result<void> Way::create_pipeline(const Gpu& gpu, std::span<const std::uint32_t> spirv) {
  const VkShaderModuleCreateInfo module_info{.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
                                             .codeSize = spirv.size_bytes(),
                                             .pCode = spirv.data()};
  VkShaderModule module = VK_NULL_HANDLE;
  VkResult result = vkCreateShaderModule(gpu.device(), &module_info, nullptr, &module);
  if (result != VK_SUCCESS) return vulkan_error("vkCreateShaderModule", result);
  const ShaderModuleHandle owner(gpu.device(), module);
  const VkComputePipelineCreateInfo info{
      .sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
      .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                .module = module,
                .pName = "main"},
      .layout = layout_.get()};
  VkPipeline pipeline = VK_NULL_HANDLE;
  result = vkCreateComputePipelines(gpu.device(), VK_NULL_HANDLE, 1, &info, nullptr, &pipeline);
  if (result != VK_SUCCESS) return vulkan_error("vkCreateComputePipelines", result);
  pipeline_ = PipelineHandle(gpu.device(), pipeline);
  return {};
}

Result<void> Way::record(const Gpu& gpu) {
  const VkCommandPoolCreateInfo pool_info{.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                          .queueFamilyIndex = gpu.candidate().queue_family};
  VkCommandPool pool = VK_NULL_HANDLE;
  VkResult result = vkCreateCommandPool(gpu.device(), &pool_info, nullptr, &pool);
  if (result != VK_SUCCESS) return vulkan_error("vkCreateCommandPool", result);
  command_pool_ = CommandPoolHandle(gpu.device(), pool);
  const VkCommandBufferAllocateInfo info{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                         .commandPool = pool,
                                         .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                         .commandBufferCount = 1};
  result = vkAllocateCommandBuffers(gpu.device(), &info, &commands_);
  if (result != VK_SUCCESS) return vulkan_error("vkAllocateCommandBuffers", result);
  const VkCommandBufferBeginInfo begin{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  result = vkBeginCommandBuffer(commands_, &begin);
  if (result != VK_SUCCESS) return vulkan_error("vkBeginCommandBuffer", result);
  vkCmdBindPipeline(commands_, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_.get());
  vkCmdBindDescriptorSets(commands_, VK_PIPELINE_BIND_POINT_COMPUTE, layout_.get(), 0, 1, &set_, 0, nullptr);
  vkCmdDispatch(commands_, kGroups, 1, 1);
  result = vkEndCommandBuffer(commands_);
  if (result != VK_SUCCESS) return vulkan_error("vkEndCommandBuffer", result);
  return {};
}

Result<double> Way::run(VkQueue queue) const {
  const VkSubmitInfo submit{
      .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &commands_};
  const std::int64_t begin_ns = now_ns();
  VkResult result = vkQueueSubmit(queue, 1, &submit, VK_NULL_HANDLE);
  if (result != VK_SUCCESS) return vulkan_error("vkQueueSubmit", result);
  result = vkQueueWaitIdle(queue);
  if (result != VK_SUCCESS) return vulkan_error("vkQueueWaitIdle", result);
  return static_cast<double>(now_ns() - begin_ns) / 1e6;
}

}  // namespace

Result<AccessTrial> try_buffer_access(const Gpu& gpu) {
  const auto words =
      GpuBuffer::create(gpu, "trial", kWords * sizeof(std::uint32_t),
                        VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                        BufferPlace::kToGpu, VK_FORMAT_R32_UINT);
  if (!words) return words.error();
  std::ranges::fill(words->mapped(), std::uint8_t{85});
  const auto sums = GpuBuffer::create(gpu, "trial sums", kGroups * kGroupSize * sizeof(std::uint32_t),
                                      VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, BufferPlace::kDevice);
  if (!sums) return sums.error();
  const auto texels = Way::create(gpu, BufferAccess::kTexels, *words, *sums);
  if (!texels) return texels.error();
  const auto storage = Way::create(gpu, BufferAccess::kStorage, *words, *sums);
  if (!storage) return storage.error();
  // In turn, and the shortest: a busy machine lengthens some of both.
  AccessTrial trial;
  for (int round = 0; round < kRounds; ++round) {
    for (const auto& [way, shortest_ms] :
         {std::pair(&*texels, &trial.texels_ms), {&*storage, &trial.storage_ms}}) {
      const auto took_ms = way->run(gpu.cast_queue());
      if (!took_ms) return took_ms.error();
      *shortest_ms = *shortest_ms > 0 ? std::min(*shortest_ms, *took_ms) : *took_ms;
    }
  }
  return trial;
}

}  // namespace fanlight
