// SPDX-License-Identifier: Apache-2.0
#include "renderer/passes/pipelines.hpp"

#include <array>
#include <string>
#include <utility>

#include "renderer/parameters/light_parameters.hpp"
#include "renderer/vulkan/debug_name.hpp"
#include "renderer/vulkan/vulkan_result.hpp"
#include "shaders/bindings.h"
#include "shaders/spirv.hpp"

namespace fanlight {

bool Pipelines::has_binding(const Gpu& gpu, std::uint32_t binding) {
  const bool twice = binding == FANLIGHT_BINDING_PACKED_TEXELS ||
                     binding == FANLIGHT_BINDING_BLOCK_MIN_MAX_TEXELS ||
                     binding == FANLIGHT_BINDING_NEIGHBOUR_MIN_MAX_TEXELS;
  return gpu.buffer_access() == BufferAccess::kTexels || !twice;
}

VkDescriptorType Pipelines::descriptor_type(const Gpu& gpu, std::uint32_t binding) {
  const bool texels = gpu.buffer_access() == BufferAccess::kTexels;
  switch (binding) {
    case FANLIGHT_BINDING_CAST_PARAMETERS:
    case FANLIGHT_BINDING_LIGHT_PARAMETERS:
      return VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
    case FANLIGHT_BINDING_VOLUME:
    case FANLIGHT_BINDING_TRANSFER:
      return VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    case FANLIGHT_BINDING_ANGLE_TABLE:
    case FANLIGHT_BINDING_FRAMES:
    case FANLIGHT_BINDING_PREPARED_FRAMES:
    case FANLIGHT_BINDING_PACKED_TEXELS:
    case FANLIGHT_BINDING_BLOCK_MIN_MAX_TEXELS:
    case FANLIGHT_BINDING_NEIGHBOUR_MIN_MAX_TEXELS:
      return texels ? VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER : VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    case FANLIGHT_BINDING_FILTERED_FRAMES:
    case FANLIGHT_BINDING_PACKED:
      return texels ? VK_DESCRIPTOR_TYPE_STORAGE_TEXEL_BUFFER : VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    default:
      return VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
  }
}

std::span<const std::uint32_t> Pipelines::spirv_of(Shader shader) const {
  using Words = std::span<const std::uint32_t>;
  const bool gathering = sampling_ == Sampling::kGathering;
  const bool is_storage = gpu_.buffer_access() == BufferAccess::kStorage;
  const auto pick = [&](Words texels, Words storage) { return is_storage ? storage : texels; };
  switch (shader) {
    case Shader::kBox:
      return pick(shaders::box_spirv, shaders::box_storage_spirv);
    case Shader::kMedian:
      return pick(shaders::median_spirv, shaders::median_storage_spirv);
    case Shader::kGuidedFit:
      return pick(shaders::guided_fit_spirv, shaders::guided_fit_storage_spirv);
    case Shader::kGuidedApply:
      return pick(shaders::guided_apply_spirv, shaders::guided_apply_storage_spirv);
    case Shader::kBlockMinMax:
      return pick(shaders::block_min_max_spirv, shaders::block_min_max_storage_spirv);
    case Shader::kNeighbourMinMax:
      return pick(shaders::neighbour_min_max_spirv, shaders::neighbour_min_max_storage_spirv);
    case Shader::kPack:
      return pick(shaders::pack_spirv, shaders::pack_storage_spirv);
    case Shader::kEmptySpace:
      return pick(shaders::empty_space_spirv, shaders::empty_space_storage_spirv);
    case Shader::kDirtyTiles:
      return pick(shaders::dirty_tiles_spirv, shaders::dirty_tiles_storage_spirv);
    case Shader::kCast:
      return gathering ? pick(shaders::cast_gathering_spirv, shaders::cast_gathering_storage_spirv)
                       : pick(shaders::cast_spirv, shaders::cast_storage_spirv);
    case Shader::kFrameSteps:
      return pick(shaders::frame_steps_spirv, shaders::frame_steps_storage_spirv);
    case Shader::kSlice:
      return gathering ? pick(shaders::slice_gathering_spirv, shaders::slice_gathering_storage_spirv)
                       : pick(shaders::slice_spirv, shaders::slice_storage_spirv);
    case Shader::kConfidence:
      return gathering
                 ? pick(shaders::confidence_gathering_spirv, shaders::confidence_gathering_storage_spirv)
                 : pick(shaders::confidence_spirv, shaders::confidence_storage_spirv);
    case Shader::kTemporal:
      return shaders::temporal_spirv;
    case Shader::kTileDepthRange:
      return shaders::tile_depth_range_spirv;
    case Shader::kCleanupTiles:
      return shaders::cleanup_tiles_spirv;
    case Shader::kIslands:
      return shaders::islands_spirv;
    case Shader::kHoles:
      return shaders::holes_spirv;
    case Shader::kMeanRows:
      return shaders::mean_rows_spirv;
    case Shader::kMeanColumns:
      return shaders::mean_columns_spirv;
    case Shader::kSmooth:
      return shaders::smooth_spirv;
    case Shader::kMinDepth:
      return shaders::min_depth_spirv;
    case Shader::kSoftLight:
      return shaders::soft_light_spirv;
    case Shader::kScatter:
      return shaders::scatter_spirv;
    case Shader::kLight:
      return shaders::light_spirv;
    case Shader::kDiffuse:
      return shaders::diffuse_spirv;
    case Shader::kFinish:
      return shaders::finish_spirv;
  }
  return {};
}

Result<std::unique_ptr<Pipelines>> Pipelines::create(const Gpu& gpu, const Config& config) {
  std::unique_ptr<Pipelines> made(new Pipelines(gpu, config));
  if (auto layouts = made->create_layouts(); !layouts) return layouts.error();
  for (const Shader shader :
       {Shader::kBlockMinMax, Shader::kNeighbourMinMax, Shader::kPack, Shader::kTemporal,
        Shader::kTileDepthRange, Shader::kCleanupTiles, Shader::kIslands, Shader::kHoles, Shader::kMeanRows,
        Shader::kMeanColumns, Shader::kMinDepth, Shader::kDiffuse, Shader::kFinish}) {
    if (auto built = made->get(PipelineKey{.shader = shader}); !built) return built.error();
  }
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

  std::array<VkDescriptorSetLayoutBinding, FANLIGHT_BINDINGS> bindings{};
  for (std::uint32_t binding = 0; binding < bindings.size(); ++binding) {
    const VkDescriptorType type = descriptor_type(gpu_, binding);
    bindings[binding] = {
        .binding = binding,
        .descriptorType = type,
        .descriptorCount = has_binding(gpu_, binding) ? 1U : 0U,
        .stageFlags = VK_SHADER_STAGE_COMPUTE_BIT,
        .pImmutableSamplers = type == VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER ? &sampler : nullptr};
  }
  const VkDescriptorSetLayoutCreateInfo set_info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                                 .bindingCount = bindings.size(),
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
  const bool in_parts = key.shader >= Shader::kTemporal;
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
