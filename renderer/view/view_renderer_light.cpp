// SPDX-License-Identifier: Apache-2.0
// ViewRenderer: the commands of passes 2 and 3.
#include <array>
#include <bit>
#include <cstdint>
#include <utility>

#include "renderer/parameters/effective_scene.hpp"
#include "renderer/parameters/light_parameters.hpp"
#include "renderer/view/view_renderer.hpp"
#include "renderer/vulkan/command_recording.hpp"
#include "shaders/bindings.h"

namespace fanlight {

namespace {

// Rows, columns or tiles that a group of pass 2's shaders handles.
constexpr std::uint32_t kLines = 8;

constexpr float kFarthestMm = FANLIGHT_MAX_DEPTH;

// A piece of a view that pauses: the main view waits for one.
constexpr double kPieceMs = 4;

/// The descriptor set after that many diffusion steps: each step reads the picture that the step before
/// wrote.
DescriptorSets::Order order_after(int steps) {
  using Order = DescriptorSets::Order;
  return steps % 2 == 0 ? Order::kLitToDiffused : Order::kDiffusedToLit;
}

/// A dispatch over lines, tiles or columns from `first` to `end` - 1, and those that share its first and last
/// groups.
LightStep on_lines(VkPipeline pipeline, int first, int end) {
  const auto first_group = static_cast<std::uint32_t>(first) / kLines;
  return {.pipeline = pipeline,
          .groups_across = groups(static_cast<std::uint32_t>(end), kLines) - first_group,
          .first_across = first_group};
}

void set_smooth_part(shaders::LightParameters& parameters, const PixelRect& part) {
  parameters.smooth_left = part.left;
  parameters.smooth_top = part.top;
  parameters.smooth_right = part.right;
  parameters.smooth_bottom = part.bottom;
}

int diffusion_steps(const Scene& scene) {
  return scene.finish.smoothing == Smoothing::kDiffusion ? scene.finish.iterations : 0;
}

}  // namespace

bool ViewRenderer::MapsKey::operator==(const MapsKey& other) const {
  // All members have four bytes, without padding between them.
  using Words = std::array<std::uint32_t, sizeof(shaders::LightParameters) / sizeof(std::uint32_t)>;
  return diffusion_steps == other.diffusion_steps &&
         std::bit_cast<Words>(parameters) == std::bit_cast<Words>(other.parameters);
}

LightStep ViewRenderer::on_tiles(VkPipeline pipeline, const PixelRect& part) const {
  const auto first_across = static_cast<std::uint32_t>(part.left / kTileSide);
  const auto first_down = static_cast<std::uint32_t>(part.top / kTileSide);
  return {.pipeline = pipeline,
          .groups_across = groups(static_cast<std::uint32_t>(part.right), kTileSide) - first_across,
          .groups_down = groups(static_cast<std::uint32_t>(part.bottom), kTileSide) - first_down,
          .first_across = first_across,
          .first_down = first_down};
}

/// Decides what passes 2 and 3 compute, and sets the part of the moving average in `parameters`.
void ViewRenderer::choose_regions(const Scene& scene, shaders::LightParameters& parameters) {
  const PixelRect all = PixelRect::whole(config_.size);
  regions_ = LightRegions::whole(config_.size);
  maps_due_ = {.parameters = parameters, .diffusion_steps = diffusion_steps(scene)};
  const bool as_last = cast_since_light_ && maps_ == maps_due_ && filter_ == scene.filter;
  partly_ = config_.passes == ViewPasses::kLight && as_last && parameters.steady == 0 &&
            2 * changed_.pixels() < all.pixels();
  if (partly_) {
    // Where nothing has changed, any tile.
    const PixelRect part = changed_.empty() ? PixelRect{.right = 1, .bottom = 1} : changed_;
    regions_ = LightRegions::of(part, parameters, maps_due_.diffusion_steps > 0, config_.size);
  }
  set_smooth_part(parameters, regions_.smooth);
  maps_.reset();
}

Result<void> ViewRenderer::add_filter_steps(const LightKeys& keys, VkPipeline confidence) {
  auto rows = device_.pipelines->get(keys.filter_rows);
  if (!rows) return rows.error();
  auto columns = device_.pipelines->get(keys.filter_columns);
  if (!columns) return columns.error();
  const LightRegions& parts = regions_;
  LightStep confidences = on_tiles(confidence, PixelRect::whole(config_.size));
  confidences.reads_frames = true;
  const int tiles = static_cast<int>(tiles_across());
  const auto on_tile_rows = [tiles](VkPipeline pipeline, const PixelRect& part) {
    return on_lines(pipeline, part.top / kTileSide * tiles, part.bottom / kTileSide * tiles);
  };
  // The moving average runs along whole rows and columns, the other filters on tiles.
  const bool mean = keys.filter_rows.shader == Shader::kMeanRows;
  const std::array<LightStep, LightSteps::kMostFilterSteps> steps = {
      on_tiles(device_.pipelines->fixed(Shader::kTemporal), parts.changed),
      on_tile_rows(device_.pipelines->fixed(Shader::kTileDepthRange), parts.changed),
      on_tile_rows(device_.pipelines->fixed(Shader::kCleanupTiles), parts.uneven),
      on_tiles(device_.pipelines->fixed(Shader::kIslands), parts.cleaned),
      confidences,
      on_tiles(device_.pipelines->fixed(Shader::kHoles), parts.filled),
      mean ? on_lines(*rows, parts.rows.top, parts.rows.bottom) : on_tiles(*rows, parts.rows),
      mean ? on_lines(*columns, parts.smooth.left, parts.smooth.right) : on_tiles(*columns, parts.smooth),
      on_lines(device_.pipelines->fixed(Shader::kMinDepth), 0, static_cast<int>(config_.size.height))};
  for (const LightStep& step : steps) {
    if (step.pipeline != VK_NULL_HANDLE) light_steps_.add(step);
  }
  return {};
}

/// The steps of the light and of pass 3.
Result<void> ViewRenderer::add_light_steps(const LightKeys& keys, const Scene& scene) {
  // Of half the picture's width and height.
  for (const auto& key : {keys.soft_light, keys.scatter_rows, keys.scatter_columns}) {
    if (!key) continue;
    const auto pipeline = device_.pipelines->get(*key);
    if (!pipeline) return pipeline.error();
    light_steps_.add({.pipeline = *pipeline,
                      .groups_across = groups(config_.size.width, 2 * kTileSide),
                      .groups_down = groups(config_.size.height, 2 * kTileSide),
                      .stage = Stage::kLight});
  }
  const auto lit = device_.pipelines->get(keys.light);
  if (!lit) return lit.error();
  LightStep light_step = on_tiles(*lit, regions_.lit);
  light_step.stage = Stage::kLight;
  light_steps_.add(light_step);
  const std::size_t light_steps = light_steps_.count_of(Stage::kLight);
  if (light_steps != measured_light_steps_) light_step_ms_[static_cast<std::size_t>(Stage::kLight)] = 0;
  measured_light_steps_ = light_steps;
  LightStep step = on_tiles(device_.pipelines->fixed(Shader::kDiffuse), regions_.finished);
  step.stage = Stage::kFinish;
  const int steps = diffusion_steps(scene);
  for (int done = 0; done < steps; ++done) {
    step.order = order_after(done);
    light_steps_.add(step);
  }
  step.pipeline = device_.pipelines->fixed(Shader::kFinish);
  step.order = order_after(steps);
  light_steps_.add(step);
  return {};
}

void ViewRenderer::record_clear_min_depth(VkCommandBuffer commands) const {
  vkCmdFillBuffer(commands, memory_.nearest.get(), 0, VK_WHOLE_SIZE,
                  std::bit_cast<std::uint32_t>(kFarthestMm));
  barrier(commands, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
          VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
          VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT);
}

void ViewRenderer::record_light_steps(VkCommandBuffer commands, std::size_t end_step) const {
  for (std::size_t index = light_steps_.next(); index < end_step; ++index) {
    const LightStep& step = light_steps_[index];
    const bool first_of_stage = index == 0 || light_steps_[index - 1].stage != step.stage;
    if (first_of_stage && step.stage == Stage::kFilter) {
      timestamps_.stamp(commands, GpuTimestamps::kFilterBegin);
      record_clear_min_depth(commands);
    }
    if (first_of_stage && step.stage == Stage::kLight)
      timestamps_.stamp(commands, GpuTimestamps::kLightBegin);
    if (first_of_stage && step.stage == Stage::kFinish) timestamps_.stamp(commands, GpuTimestamps::kLightEnd);
    if (index == light_steps_.next() || light_steps_[index - 1].order != step.order)
      descriptors_.bind(commands, *device_.pipelines, step.order);
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, step.pipeline);
    vkCmdDispatchBase(commands, step.first_across, step.first_down, 0, step.groups_across, step.groups_down,
                      1);
    pass_barrier(commands);
  }
}

void ViewRenderer::record_read_back(VkCommandBuffer commands) const {
  barrier(commands, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
          VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_READ_BIT);
  timestamps_.stamp(commands, GpuTimestamps::kFinishEnd);
  const VkBufferCopy all{.size = memory_.read_back.bytes()};
  vkCmdCopyBuffer(commands, memory_.finished.get(), memory_.read_back.get(), 1, &all);
  const VkBufferCopy depths{.size = memory_.read_back_depth.bytes()};
  vkCmdCopyBuffer(commands, memory_.smooth_depth.get(), memory_.read_back_depth.get(), 1, &depths);
  barrier(commands, VK_PIPELINE_STAGE_2_COPY_BIT | VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
          VK_ACCESS_2_TRANSFER_WRITE_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT, VK_PIPELINE_STAGE_2_HOST_BIT,
          VK_ACCESS_2_HOST_READ_BIT);
  timestamps_.stamp(commands, GpuTimestamps::kReadBackEnd);
}

/// The pipeline that computes the filter's weights; null where the scene does not ask for them, or where they
/// are known already. Where they cannot be had any more, all weights become 1 in `parameters`.
Result<VkPipeline> ViewRenderer::confidence_pipeline(const PipelineKey& key, const Scene& scene,
                                                     bool frames_gone,
                                                     shaders::LightParameters& parameters) const {
  const VkPipeline none = VK_NULL_HANDLE;
  if (scene.filter.weights != FilterWeights::kConfidence || confidence_known_) return none;
  if (frames_gone || config_.passes == ViewPasses::kLight) {
    // The frames that they would be computed from are gone: the next volume's picture will have them.
    parameters.confidence_counts = 0;
    return none;
  }
  return device_.pipelines->get(key);
}

Result<bool> ViewRenderer::add_confidence(const Scene& wanted, const VolumeBindings& volume) {
  const Scene scene = effective_scene(wanted, volume.geometry, config_.size, volume.levels);
  const bool due =
      scene.filter.weights == FilterWeights::kConfidence && !confidence_known_ && !volume.frames_gone;
  if (!due) return false;
  const auto pipeline = device_.pipelines->get(light_keys(scene, volume.geometry.kind).confidence);
  if (!pipeline) return pipeline.error();
  if (auto begun = begin_commands(cast_commands_); !begun) return begun.error();
  descriptors_.bind(cast_commands_, *device_.pipelines, DescriptorSets::Order::kLitToDiffused);
  vkCmdBindPipeline(cast_commands_, VK_PIPELINE_BIND_POINT_COMPUTE, *pipeline);
  vkCmdDispatch(cast_commands_, tiles_across(), tiles_down(), 1);
  record_maps_for_host(cast_commands_);
  if (auto submitted = timeline_.submit(device_.gpu->cast_queue(), cast_commands_, other_work_); !submitted)
    return submitted.error();
  confidence_known_ = true;
  return true;
}

Result<void> ViewRenderer::begin_light(const Scene& wanted, const VolumeBindings& volume, History history) {
  const Scene scene = effective_scene(wanted, volume.geometry, config_.size, volume.levels);
  const LightKeys keys = light_keys(scene, volume.geometry.kind);
  shaders::LightParameters parameters = light_parameters(scene, config_.size, farthest_mm_);
  if (history == History::kNone) parameters.steady = 0;
  // A cast has reset all time stamps, and the GPU may be writing the cast's now.
  if (!cast_since_light_ || config_.passes == ViewPasses::kLight) reset_times();
  light_steps_.clear();
  confidence_due_ = false;

  const bool filters = cast_since_light_ || filter_ != scene.filter;
  VkPipeline confidence = VK_NULL_HANDLE;
  if (filters) {
    const auto known = confidence_pipeline(keys.confidence, scene, volume.frames_gone, parameters);
    if (!known) return known.error();
    confidence = *known;
  } else {
    // The maps stay those of the last filter, whatever it would be now.
    parameters.steady = filtered_.steady;
    parameters.confidence_counts = filtered_.confidence_counts;
  }
  choose_regions(scene, parameters);
  memory_.light_parameters.mapped_as<shaders::LightParameters>() = parameters;
  if (filters) {
    confidence_due_ = confidence != VK_NULL_HANDLE;
    if (auto added = add_filter_steps(keys, confidence); !added) return added;
    if (filter_due_ != scene.filter) light_step_ms_[static_cast<std::size_t>(Stage::kFilter)] = 0;
    filter_due_ = scene.filter;
    filter_.reset();
  }
  return add_light_steps(keys, scene);
}

Result<void> ViewRenderer::change_light(const Scene& wanted, const VolumeBindings& volume) {
  const Scene scene = effective_scene(wanted, volume.geometry, config_.size, volume.levels);
  auto& parameters = memory_.light_parameters.mapped_as<shaders::LightParameters>();
  shaders::LightParameters changed = light_parameters(scene, config_.size, farthest_mm_);
  // What begin_light() knew besides the scene.
  changed.steady = parameters.steady;
  changed.confidence_counts = parameters.confidence_counts;
  maps_due_ = {.parameters = changed, .diffusion_steps = diffusion_steps(scene)};
  // Another light changes pixels that keep their depth.
  regions_.lit = regions_.finished = LightRegions::whole(config_.size).lit;
  set_smooth_part(changed, regions_.smooth);
  parameters = changed;
  light_steps_.drop_from(Stage::kLight);
  return add_light_steps(light_keys(scene, volume.geometry.kind), scene);
}

/// Submits the steps before end_step that were not submitted yet, and after the last one the read-back.
Result<void> ViewRenderer::submit_light(std::size_t end_step) {
  const VkCommandBuffer commands = light_commands_;
  if (auto begun = begin_commands(commands); !begun) return begun;
  begin_piece(commands, light_steps_[light_steps_.next()].stage);
  // The other slot's filter may run just before this one's, and reads its buffers.
  barrier(commands, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
          VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
          VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
          VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT |
              VK_ACCESS_2_TRANSFER_WRITE_BIT);
  if (cast_to_copy_ != nullptr) memory_.copy_cast(commands, *cast_to_copy_);
  record_light_steps(commands, end_step);
  const bool last = end_step == light_steps_.count();
  if (last) record_read_back(commands);
  end_piece(commands);
  if (auto submitted = timeline_.submit(device_.gpu->light_queue(), commands, other_work_); !submitted)
    return submitted;
  cast_to_copy_ = nullptr;
  light_steps_.submit_until(end_step);
  if (!last) return {};
  // Only now: after an error, or where the picture was given up, the next one does all of it.
  confidence_known_ |= confidence_due_;
  filter_ = filter_due_;
  maps_ = maps_due_;
  filtered_ = maps_due_.parameters;
  changed_ = {};
  cast_since_light_ = false;
  return {};
}

Result<void> ViewRenderer::light(const Scene& scene, const VolumeBindings& volume, History history) {
  if (auto begun = begin_light(scene, volume, history); !begun) return begun;
  return submit_light(light_steps_.count());
}

Result<void> ViewRenderer::light_next_piece() {
  const Stage next = light_steps_[light_steps_.next()].stage;
  // Only a changed light is waited for here, and it comes too late for this picture once its light is begun.
  if (config_.passes == ViewPasses::kLight && next != Stage::kFilter)
    return submit_light(light_steps_.count());
  const auto stage = static_cast<std::size_t>(next);
  const double known_ms = light_step_ms_[stage];
  const double whole_ms = known_ms > 0 ? known_ms : kPieceMs;
  const double share = static_cast<double>(regions_.smooth.pixels()) / pixels();
  const double step_ms = next == Stage::kFilter ? share * whole_ms : whole_ms;
  return submit_light(light_steps_.end_of_piece(step_ms, kPieceMs));
}

}  // namespace fanlight
