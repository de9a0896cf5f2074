#include "renderer/passes.hpp"

#include <array>

#include "renderer/vulkan_result.hpp"
#include "shaders/bindings.h"
#include "shaders/spirv.hpp"

namespace fanlight {

namespace {

VkDescriptorType type_of(std::uint32_t binding) {
  switch (binding) {
    case FANLIGHT_BINDING_CAST_PARAMETERS:
    case FANLIGHT_BINDING_LIGHT_PARAMETERS:
      return VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
    case FANLIGHT_BINDING_VOLUME:
    case FANLIGHT_BINDING_FAN_TABLE:
      return VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    default:
      return VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
  }
}

}  // namespace

Result<std::unique_ptr<Passes>> Passes::create(const Gpu& gpu) {
  std::unique_ptr<Passes> made(new Passes(gpu));
  if (auto layouts = made->create_layouts(); !layouts) return layouts.error();

  const std::pair<PipelineHandle*, std::span<const std::uint32_t>> fixed[] = {
      {&made->filter_rows_, shaders::filter_rows_spirv},
      {&made->filter_columns_, shaders::filter_columns_spirv},
      {&made->light_, shaders::light_spirv},
      {&made->finish_, shaders::finish_spirv}};
  for (const auto& [handle, spirv] : fixed) {
    auto built = made->pipeline(spirv, nullptr);
    if (!built) return built.error();
    *handle = std::move(*built);
  }
  return made;
}

Result<void> Passes::create_layouts() {
  const VkSamplerCreateInfo sampler_info{.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO,
                                         .magFilter = VK_FILTER_LINEAR,
                                         .minFilter = VK_FILTER_LINEAR,
                                         .addressModeU = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                         .addressModeV = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                         // No sample lies beyond the first or last frame, so this mode
                                         // changes no result. But it keeps llvmpipe, which filters 8 bit
                                         // textures in 8 bit arithmetic where all modes are simple ones,
                                         // to floats: closer to the truth, and faster (renderer/README.md).
                                         .addressModeW = VK_SAMPLER_ADDRESS_MODE_MIRRORED_REPEAT};
  VkSampler sampler = VK_NULL_HANDLE;
  VkResult result = vkCreateSampler(gpu_.device(), &sampler_info, nullptr, &sampler);
  if (result != VK_SUCCESS) return vulkan_error("vkCreateSampler", result);
  sampler_ = SamplerHandle(gpu_.device(), sampler);

  std::array<VkDescriptorSetLayoutBinding, FANLIGHT_BINDINGS> bindings{};
  for (std::uint32_t binding = 0; binding < bindings.size(); ++binding) {
    const VkDescriptorType type = type_of(binding);
    bindings[binding] = {
        .binding = binding,
        .descriptorType = type,
        .descriptorCount = 1,
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

  // Which tile pass 1 begins with.
  const VkPushConstantRange band{.stageFlags = VK_SHADER_STAGE_COMPUTE_BIT, .size = sizeof(std::uint32_t)};
  const VkPipelineLayoutCreateInfo layout_info{.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                               .setLayoutCount = 1,
                                               .pSetLayouts = &set_layout,
                                               .pushConstantRangeCount = 1,
                                               .pPushConstantRanges = &band};
  VkPipelineLayout layout = VK_NULL_HANDLE;
  result = vkCreatePipelineLayout(gpu_.device(), &layout_info, nullptr, &layout);
  if (result != VK_SUCCESS) return vulkan_error("vkCreatePipelineLayout", result);
  layout_ = PipelineLayoutHandle(gpu_.device(), layout);
  return {};
}

Result<PipelineHandle> Passes::pipeline(std::span<const std::uint32_t> spirv,
                                        const VkSpecializationInfo* constants) {
  const VkShaderModuleCreateInfo module_info{.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
                                             .codeSize = spirv.size_bytes(),
                                             .pCode = spirv.data()};
  VkShaderModule module = VK_NULL_HANDLE;
  VkResult result = vkCreateShaderModule(gpu_.device(), &module_info, nullptr, &module);
  if (result != VK_SUCCESS) return vulkan_error("vkCreateShaderModule", result);
  const ShaderModuleHandle owner(gpu_.device(), module);

  const VkComputePipelineCreateInfo info{
      .sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
      .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                .module = module,
                .pName = "main",
                .pSpecializationInfo = constants},
      .layout = layout_.get()};
  VkPipeline pipeline = VK_NULL_HANDLE;
  result = vkCreateComputePipelines(gpu_.device(), VK_NULL_HANDLE, 1, &info, nullptr, &pipeline);
  if (result != VK_SUCCESS) return vulkan_error("vkCreateComputePipelines", result);
  return PipelineHandle(gpu_.device(), pipeline);
}

Result<VkPipeline> Passes::cast(int window, Mode mode) {
  const auto key = std::pair(window, mode);
  if (const auto known = cast_.find(key); known != cast_.end()) return known->second.get();

  struct Constants {
    std::int32_t window;
    VkBool32 composite;
  };
  const Constants values{window, mode == Mode::kVolume ? VK_TRUE : VK_FALSE};
  const std::array<VkSpecializationMapEntry, 2> entries = {
      {{0, offsetof(Constants, window), sizeof values.window},
       {1, offsetof(Constants, composite), sizeof values.composite}}};
  const VkSpecializationInfo constants{.mapEntryCount = entries.size(),
                                       .pMapEntries = entries.data(),
                                       .dataSize = sizeof values,
                                       .pData = &values};
  auto built = pipeline(shaders::cast_spirv, &constants);
  if (!built) return built.error();
  return cast_.emplace(key, std::move(*built)).first->second.get();
}

}  // namespace fanlight
