// SPDX-License-Identifier: Apache-2.0
#include "renderer/pipelines/pipelines.hpp"

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "renderer/parameters/light_parameters.hpp"
#include "renderer/vulkan/debug_name.hpp"
#include "renderer/vulkan/shader_interface.hpp"
#include "renderer/vulkan/vulkan_result.hpp"
#include "shaders/spirv.hpp"

namespace fanlight {

std::string_view name_of(Shader shader) {
  return shaders::passes()[static_cast<std::size_t>(shader)].name;
}

std::span<const std::uint32_t> Pipelines::spirv_of(Shader shader) const {
  const shaders::Pass& pass = shaders::passes()[static_cast<std::size_t>(shader)];
  const bool is_storage = gpu_.buffer_access() == BufferAccess::kStorage;
  if (sampling_ == Sampling::kGathering) return is_storage ? pass.gathering_storage : pass.gathering_texels;
  return is_storage ? pass.storage : pass.texels;
}

Result<std::unique_ptr<Pipelines>> Pipelines::create(const Gpu& gpu, const Config& config) {
  std::unique_ptr<Pipelines> made(new Pipelines(gpu, config));
  if (auto layouts = made->create_layouts(); !layouts) return layouts.error();
  for (std::size_t row = 0; row < shaders::passes().size(); ++row) {
    const auto shader = static_cast<Shader>(row);
    if (!shaders::passes()[row].has_fixed_pipeline || !made->runs(shader)) continue;
    if (auto built = made->get(PipelineKey{.shader = shader}); !built) return built.error();
  }
  for (const PipelineKey& key : temporal_variants()) {
    if (auto built = made->get(key); !built) return built.error();
  }
  if (!config.lights) return made;
  for (const PipelineKey& key : light_variants()) {
    if (auto built = made->get(key); !built) return built.error();
  }
  return made;
}

Result<void> Pipelines::create_layouts() {
  const VkSamplerCreateInfo sampler_info{.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO,
                                         .magFilter = VK_FILTER_LINEAR,
                                         .minFilter = VK_FILTER_LINEAR,
                                         .addressModeU = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                         .addressModeV = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                         // No sample lies beyond the first or last frame, so this mode
                                         // changes no result. But it makes llvmpipe filter in floats
                                         // rather than in its 8 bit arithmetic, which it uses for 8 bit
                                         // textures with simple modes: more exact, and faster
                                         // (renderer/README.md).
                                         .addressModeW = VK_SAMPLER_ADDRESS_MODE_MIRRORED_REPEAT};
  VkSampler sampler = VK_NULL_HANDLE;
  VkResult result = vkCreateSampler(gpu_.device(), &sampler_info, nullptr, &sampler);
  if (result != VK_SUCCESS) return vulkan_error("vkCreateSampler", result);
  sampler_ = SamplerHandle(gpu_.device(), sampler);

  std::vector<VkDescriptorSetLayoutBinding> bindings;
  const BindingTypes& types = binding_types(gpu_.buffer_access());
  for (std::uint32_t binding = 0; binding < types.size(); ++binding) {
    if (!types[binding]) continue;
    const bool is_texture = types[binding] == VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    bindings.push_back({.binding = binding,
                        .descriptorType = *types[binding],
                        .descriptorCount = 1,
                        .stageFlags = VK_SHADER_STAGE_COMPUTE_BIT,
                        .pImmutableSamplers = is_texture ? &sampler : nullptr});
  }
  const VkDescriptorSetLayoutCreateInfo set_info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                                 .bindingCount = static_cast<std::uint32_t>(bindings.size()),
                                                 .pBindings = bindings.data()};
  VkDescriptorSetLayout set_layout = VK_NULL_HANDLE;
  result = vkCreateDescriptorSetLayout(gpu_.device(), &set_info, nullptr, &set_layout);
  if (result != VK_SUCCESS) return vulkan_error("vkCreateDescriptorSetLayout", result);
  set_layout_ = DescriptorSetLayoutHandle(gpu_.device(), set_layout);

  const VkPushConstantRange push{.stageFlags = VK_SHADER_STAGE_COMPUTE_BIT, .size = kPushBytes};
  const VkPipelineLayoutCreateInfo layout_info{.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                               .setLayoutCount = 1,
                                               .pSetLayouts = &set_layout,
                                               .pushConstantRangeCount = 1,
                                               .pPushConstantRanges = &push};
  VkPipelineLayout layout = VK_NULL_HANDLE;
  result = vkCreatePipelineLayout(gpu_.device(), &layout_info, nullptr, &layout);
  if (result != VK_SUCCESS) return vulkan_error("vkCreatePipelineLayout", result);
  layout_ = PipelineLayoutHandle(gpu_.device(), layout);
  return {};
}

Result<PipelineHandle> Pipelines::build(const PipelineKey& key) const {
  const auto spirv = spirv_of(key.shader);
  const VkShaderModuleCreateInfo module_info{.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
                                             .codeSize = spirv.size_bytes(),
                                             .pCode = spirv.data()};
  VkShaderModule module = VK_NULL_HANDLE;
  VkResult result = vkCreateShaderModule(gpu_.device(), &module_info, nullptr, &module);
  if (result != VK_SUCCESS) return vulkan_error("vkCreateShaderModule", result);
  const ShaderModuleHandle owner(gpu_.device(), module);

  const auto& constants = key.constants;
  std::array<VkSpecializationMapEntry, std::tuple_size_v<decltype(key.constants)>> entries{};
  for (std::uint32_t id = 0; id < entries.size(); ++id) {
    entries[id] = {.constantID = id,
                   .offset = static_cast<std::uint32_t>(id * sizeof constants[id]),
                   .size = sizeof constants[id]};
  }
  const VkSpecializationInfo values{.mapEntryCount = entries.size(),
                                    .pMapEntries = entries.data(),
                                    .dataSize = sizeof constants,
                                    .pData = constants.data()};
  // Passes 2 and 3 may compute a part of the picture.
  const bool in_parts = key.shader >= Shader::kMapCells;
  const VkComputePipelineCreateInfo info{
      .sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
      .flags = in_parts ? VkPipelineCreateFlags{VK_PIPELINE_CREATE_DISPATCH_BASE_BIT} : 0,
      .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                .module = module,
                .pName = "main",
                .pSpecializationInfo = &values},
      .layout = layout_.get()};
  VkPipeline pipeline = VK_NULL_HANDLE;
  result = vkCreateComputePipelines(gpu_.device(), cache_.get(), 1, &info, nullptr, &pipeline);
  if (result != VK_SUCCESS) return vulkan_error("vkCreateComputePipelines", result);
  set_debug_name(gpu_, pipeline, std::string(name_of(key.shader)).c_str());
  return PipelineHandle(gpu_.device(), pipeline);
}

Result<VkPipeline> Pipelines::get(const PipelineKey& key) {
  if (const auto known = pipelines_.find(key); known != pipelines_.end()) return known->second.get();
  auto built = build(key);
  if (!built) return built.error();
  return pipelines_.emplace(key, std::move(*built)).first->second.get();
}

Result<VkPipeline> Pipelines::get(const std::optional<PipelineKey>& key) {
  return key ? get(*key) : Result<VkPipeline>(VkPipeline{VK_NULL_HANDLE});
}

}  // namespace fanlight
