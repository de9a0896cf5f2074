// SPDX-License-Identifier: Apache-2.0
// ViewRenderer: the commands of passes 2 and 3.
#include <array>
#include <bit>
#include <utility>

#include "renderer/parameters/light_parameters.hpp"
#include "renderer/view/view_renderer.hpp"
#include "renderer/vulkan/command_recording.hpp"
#include "shaders/bindings.h"

namespace fanlight {

namespace {

// Rows, columns or tiles that a group of pass 2's shaders handles.
constexpr std::uint32_t kLines = 8;

constexpr float kFarthestMm = FANLIGHT_MAX_DEPTH;

/// The descriptor set after that many diffusion steps: each step reads the picture that the step before
/// wrote.
DescriptorSets::Order order_after(int steps) {
  using Order = DescriptorSets::Order;
  return steps % 2 == 0 ? Order::kLitToDiffused : Order::kDiffusedToLit;
}

}  // namespace

Result<void> ViewRenderer::record_depth_filter(VkCommandBuffer commands, Pipelines& pipelines,
                                               const LightKeys& keys, VkPipeline confidence) {
  struct Step {
    VkPipeline pipeline;
    std::uint32_t groups_across;
    std::uint32_t groups_down;
  };
  auto rows = pipelines.get(keys.filter_rows);
  if (!rows) return rows.error();
  auto columns = pipelines.get(keys.filter_columns);
  if (!columns) return columns.error();
  // The moving average runs along whole rows and columns, the other filters on tiles.
  const bool mean = keys.filter_rows.shader == Shader::kMeanRows;
  const Step row_step =
      mean ? Step{*rows, groups(config_.size.height, kLines), 1} : Step{*rows, tiles_across(), tiles_down()};
  const Step column_step = mean ? Step{*columns, groups(config_.size.width, kLines), 1}
                                : Step{*columns, tiles_across(), tiles_down()};
  const Step steps[] = {
      {pipelines.fixed(Shader::kTemporal), tiles_across(), tiles_down()},
      {pipelines.fixed(Shader::kTileDepthRange), groups(tiles_across() * tiles_down(), kLines), 1},
      {pipelines.fixed(Shader::kCleanupTiles), groups(tiles_across() * tiles_down(), kLines), 1},
      {pipelines.fixed(Shader::kIslands), tiles_across(), tiles_down()},
      {confidence, tiles_across(), tiles_down()},
      {pipelines.fixed(Shader::kHoles), tiles_across(), tiles_down()},
      row_step,
      column_step,
      {pipelines.fixed(Shader::kMinDepth), groups(config_.size.height, kLines), 1}};
  vkCmdFillBuffer(commands, memory_.nearest.get(), 0, VK_WHOLE_SIZE,
                  std::bit_cast<std::uint32_t>(kFarthestMm));
  barrier(commands, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
          VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
          VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT);
  for (const Step& step : steps) {
    if (step.pipeline == VK_NULL_HANDLE) continue;
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, step.pipeline);
    vkCmdDispatch(commands, step.groups_across, step.groups_down, 1);
    pass_barrier(commands);
  }
  return {};
}

void ViewRenderer::record_finish(VkCommandBuffer commands, const Pipelines& pipelines,
                                 const Scene& scene) const {
  const int steps = scene.finish.smoothing == Smoothing::kDiffusion ? scene.finish.iterations : 0;
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipelines.fixed(Shader::kDiffuse));
  for (int step = 0; step < steps; ++step) {
    descriptors_.bind(commands, pipelines, order_after(step));
    vkCmdDispatch(commands, tiles_across(), tiles_down(), 1);
    pass_barrier(commands);
  }
  descriptors_.bind(commands, pipelines, order_after(steps));
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipelines.fixed(Shader::kFinish));
  vkCmdDispatch(commands, tiles_across(), tiles_down(), 1);
}

void ViewRenderer::record_read_back(VkCommandBuffer commands) const {
  barrier(commands, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
          VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_READ_BIT);
  timestamps_.stamp(commands, GpuTimestamps::kFinishEnd);
  const VkBufferCopy all{.size = memory_.read_back.bytes()};
  vkCmdCopyBuffer(commands, memory_.finished.get(), memory_.read_back.get(), 1, &all);
  const VkBufferCopy depths{.size = memory_.read_back_depth.bytes()};
  vkCmdCopyBuffer(commands, memory_.smooth_depth.get(), memory_.read_back_depth.get(), 1, &depths);
  barrier(commands, VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
          VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT);
  timestamps_.stamp(commands, GpuTimestamps::kReadBackEnd);
}

/// The pipeline that computes the filter's weights; null where the scene does not ask for them, or where they
/// are known already.
Result<VkPipeline> ViewRenderer::confidence_pipeline(Pipelines& pipelines, const PipelineKey& key,
                                                     const Scene& scene, bool frames_gone) {
  const VkPipeline none = VK_NULL_HANDLE;
  if (scene.filter.weights != FilterWeights::kConfidence || confidence_known_) return none;
  if (frames_gone) {
    // The frames that they would be computed from are gone: the next volume's picture will have them.
    memory_.light_parameters.mapped_as<shaders::LightParameters>().confidence_counts = 0;
    return none;
  }
  return pipelines.get(key);
}

Result<void> ViewRenderer::light(const Gpu& gpu, Pipelines& pipelines, const Scene& scene,
                                 const VolumeBindings& volume, History history) {
  const LightKeys keys = light_keys(scene, volume.geometry.kind);
  shaders::LightParameters parameters = light_parameters(scene, config_.size, farthest_mm_);
  if (history == History::kNone) parameters.steady = 0;
  memory_.light_parameters.mapped_as<shaders::LightParameters>() = parameters;
  const bool filter_due = cast_since_light_ || filter_ != scene.filter;
  // A cast has reset all time stamps, and the GPU may be writing the cast's now.
  if (!cast_since_light_) timestamps_.reset(gpu);

  auto confidence = confidence_pipeline(pipelines, keys.confidence, scene, volume.frames_gone);
  if (!confidence) return confidence.error();
  auto lit = pipelines.get(keys.light);
  if (!lit) return lit.error();
  const VkCommandBuffer commands = light_commands_;
  if (auto begun = begin_commands(commands); !begun) return begun;
  // The other slot's filter may run just before this one's, and reads its buffers.
  barrier(commands, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
          VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
          VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
          VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT |
              VK_ACCESS_2_TRANSFER_WRITE_BIT);
  descriptors_.bind(commands, pipelines, DescriptorSets::Order::kLitToDiffused);
  if (filter_due) {
    timestamps_.stamp(commands, GpuTimestamps::kFilterBegin);
    if (auto recorded = record_depth_filter(commands, pipelines, keys, *confidence); !recorded)
      return recorded;
  }
  timestamps_.stamp(commands, GpuTimestamps::kLightBegin);
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, *lit);
  vkCmdDispatch(commands, tiles_across(), tiles_down(), 1);
  pass_barrier(commands);
  timestamps_.stamp(commands, GpuTimestamps::kLightEnd);
  record_finish(commands, pipelines, scene);
  record_read_back(commands);
  if (auto submitted = timeline_.submit(gpu.light_queue(), commands, other_work_); !submitted)
    return submitted;
  // Only now: after an error the next call does all of it.
  filter_ = scene.filter;
  cast_since_light_ = false;
  confidence_known_ |= *confidence != VK_NULL_HANDLE;
  return {};
}

}  // namespace fanlight
