#include "renderer/passes.hpp"

#include <array>

#include "renderer/view.hpp"
#include "renderer/vulkan_result.hpp"
#include "shaders/bindings.h"
#include "shaders/spirv.hpp"

namespace fanlight {

namespace {

/// Whether pass 1 can pass over anything: a mean or a minimum needs all of a ray.
bool may_skip(const Scene& scene, Skipping skipping) {
  const int kept = kept_by(scene.mode);
  return skipping == Skipping::kOn && (kept == FANLIGHT_KEEP_NOTHING || kept == FANLIGHT_KEEP_COLOUR);
}

int sign_of(EdgeSign sign) {
  return sign == EdgeSign::kDarkToBright ? 1 : sign == EdgeSign::kBrightToDark ? -1 : 0;
}

}  // namespace

VkDescriptorType Passes::descriptor_type(std::uint32_t binding) {
  switch (binding) {
    case FANLIGHT_BINDING_CAST_PARAMETERS:
    case FANLIGHT_BINDING_LIGHT_PARAMETERS:
      return VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
    case FANLIGHT_BINDING_VOLUME:
    case FANLIGHT_BINDING_TRANSFER:
      return VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    case FANLIGHT_BINDING_ANGLE_TABLE:
    case FANLIGHT_BINDING_FRAMES:
    case FANLIGHT_BINDING_READY:
    case FANLIGHT_BINDING_COLUMNS:
    case FANLIGHT_BINDING_BLOCK_TEXELS:
    case FANLIGHT_BINDING_BOUND_TEXELS:
      return VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
    case FANLIGHT_BINDING_PREPARED:
    case FANLIGHT_BINDING_PACKED:
      return VK_DESCRIPTOR_TYPE_STORAGE_TEXEL_BUFFER;
    default:
      return VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
  }
}

std::span<const std::uint32_t> Passes::spirv_of(Shader shader) const {
  const bool gathering = sampling_ == Sampling::kGathering;
  switch (shader) {
    case Shader::kBox:
      return shaders::box_spirv;
    case Shader::kMedian:
      return shaders::median_spirv;
    case Shader::kGuide:
      return shaders::guide_spirv;
    case Shader::kGuided:
      return shaders::guided_spirv;
    case Shader::kBlocks:
      return shaders::blocks_spirv;
    case Shader::kBounds:
      return shaders::bounds_spirv;
    case Shader::kPack:
      return shaders::pack_spirv;
    case Shader::kSegments:
      return shaders::segments_spirv;
    case Shader::kChanged:
      return shaders::changed_spirv;
    case Shader::kCast:
      return gathering ? shaders::cast_gathering_spirv : shaders::cast_spirv;
    case Shader::kSlice:
      return gathering ? shaders::slice_gathering_spirv : shaders::slice_spirv;
    case Shader::kSteady:
      return shaders::steady_spirv;
    case Shader::kTiles:
      return shaders::tiles_spirv;
    case Shader::kUneven:
      return shaders::uneven_spirv;
    case Shader::kIslands:
      return shaders::islands_spirv;
    case Shader::kConfidence:
      return gathering ? shaders::confidence_gathering_spirv : shaders::confidence_spirv;
    case Shader::kHoles:
      return shaders::holes_spirv;
    case Shader::kMeanRows:
      return shaders::mean_rows_spirv;
    case Shader::kMeanColumns:
      return shaders::mean_columns_spirv;
    case Shader::kSmooth:
      return shaders::smooth_spirv;
    case Shader::kNearest:
      return shaders::nearest_spirv;
    case Shader::kLight:
      return shaders::light_spirv;
    case Shader::kDiffuse:
      return shaders::diffuse_spirv;
    case Shader::kFinish:
      return shaders::finish_spirv;
  }
  return {};
}

Result<std::unique_ptr<Passes>> Passes::create(const Gpu& gpu, Sampling sampling) {
  std::unique_ptr<Passes> made(new Passes(gpu, sampling));
  if (auto layouts = made->create_layouts(); !layouts) return layouts.error();
  for (const Shader shader :
       {Shader::kBlocks, Shader::kBounds, Shader::kPack, Shader::kSteady, Shader::kTiles, Shader::kUneven,
        Shader::kIslands, Shader::kHoles, Shader::kMeanRows, Shader::kMeanColumns, Shader::kNearest,
        Shader::kDiffuse, Shader::kFinish}) {
    if (auto built = made->pipeline(shader, {}); !built) return built.error();
  }
  // A light and a filter may be asked for in mid-stream, where nobody should wait for a pipeline.
  for (const std::int32_t first : {0, 1}) {
    for (const std::int32_t second : {0, 1}) {
      if (auto built = made->pipeline(Shader::kLight, {first, second}); !built) return built.error();
      if (auto built = made->pipeline(Shader::kSmooth, {first, second}); !built) return built.error();
    }
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
    const VkDescriptorType type = descriptor_type(binding);
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

Result<PipelineHandle> Passes::build(Shader shader, const Constants& constants) {
  const auto spirv = spirv_of(shader);
  const VkShaderModuleCreateInfo module_info{.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
                                             .codeSize = spirv.size_bytes(),
                                             .pCode = spirv.data()};
  VkShaderModule module = VK_NULL_HANDLE;
  VkResult result = vkCreateShaderModule(gpu_.device(), &module_info, nullptr, &module);
  if (result != VK_SUCCESS) return vulkan_error("vkCreateShaderModule", result);
  const ShaderModuleHandle owner(gpu_.device(), module);

  // A shader ignores the constants that it does not declare.
  std::array<VkSpecializationMapEntry, std::tuple_size_v<Constants>> entries{};
  for (std::uint32_t id = 0; id < entries.size(); ++id) {
    entries[id] = {.constantID = id,
                   .offset = static_cast<std::uint32_t>(id * sizeof constants[id]),
                   .size = sizeof constants[id]};
  }
  const VkSpecializationInfo values{.mapEntryCount = entries.size(),
                                    .pMapEntries = entries.data(),
                                    .dataSize = sizeof constants,
                                    .pData = constants.data()};
  const VkComputePipelineCreateInfo info{
      .sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
      .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                .module = module,
                .pName = "main",
                .pSpecializationInfo = &values},
      .layout = layout_.get()};
  VkPipeline pipeline = VK_NULL_HANDLE;
  result = vkCreateComputePipelines(gpu_.device(), VK_NULL_HANDLE, 1, &info, nullptr, &pipeline);
  if (result != VK_SUCCESS) return vulkan_error("vkCreateComputePipelines", result);
  return PipelineHandle(gpu_.device(), pipeline);
}

Result<VkPipeline> Passes::pipeline(Shader shader, const Constants& constants) {
  const auto key = std::pair(shader, constants);
  if (const auto known = pipelines_.find(key); known != pipelines_.end()) return known->second.get();
  auto built = build(shader, constants);
  if (!built) return built.error();
  return pipelines_.emplace(key, std::move(*built)).first->second.get();
}

Result<VkPipeline> Passes::speckle(Shader shader, const Scene::Speckle& options) {
  return pipeline(shader, {options.size, shader == Shader::kMedian ? options.across : 0});
}

Result<VkPipeline> Passes::cast(const Scene& scene, FrameKind kind, Skipping skipping, int tiles) {
  return pipeline(Shader::kCast,
                  {scene.detector.window, kept_by(scene.mode), kind == FrameKind::kConvexLines ? 1 : 0,
                   scene.detector.place == SurfacePlace::kRefined ? 1 : 0, scene.rays.window / 2,
                   may_skip(scene, skipping) ? 1 : 0, sign_of(scene.detector.sign), tiles});
}

Result<VkPipeline> Passes::segments(const Scene& scene, FrameKind kind, Skipping skipping) {
  if (!may_skip(scene, skipping)) return VkPipeline{VK_NULL_HANDLE};
  return pipeline(Shader::kSegments,
                  {scene.detector.window, kept_by(scene.mode), kind == FrameKind::kConvexLines ? 1 : 0});
}

Result<VkPipeline> Passes::changed(const Scene& scene) {
  return pipeline(Shader::kChanged, {scene.detector.window});
}

Result<VkPipeline> Passes::confidence(const Scene& scene, FrameKind kind) {
  return pipeline(Shader::kConfidence, {scene.detector.window, 0, kind == FrameKind::kConvexLines ? 1 : 0, 0,
                                        scene.rays.window / 2});
}

Result<VkPipeline> Passes::light(const Scene& scene) {
  return pipeline(Shader::kLight, {scene.camera.projection == Projection::kPerspective ? 1 : 0,
                                   scene.shadow.softness_mm > 0 ? 1 : 0});
}

Result<VkPipeline> Passes::slice(FrameKind kind) {
  return pipeline(Shader::kSlice, {0, 0, kind == FrameKind::kConvexLines ? 1 : 0});
}

Result<VkPipeline> Passes::smooth(Axis axis, DepthFilter kind) {
  return pipeline(Shader::kSmooth,
                  {axis == Axis::kColumns ? 1 : 0, kind == DepthFilter::kEdgePreserving ? 1 : 0});
}

}  // namespace fanlight
