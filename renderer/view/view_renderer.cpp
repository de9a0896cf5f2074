// SPDX-License-Identifier: Apache-2.0
#include "renderer/view/view_renderer.hpp"

#include <algorithm>
#include <utility>

#include "renderer/parameters/effective_scene.hpp"
#include "renderer/parameters/transfer_table.hpp"
#include "renderer/vulkan/command_recording.hpp"
#include "renderer/vulkan/debug_name.hpp"
#include "renderer/vulkan/vulkan_result.hpp"
#include "shaders/bindings.h"

namespace fanlight {

Result<ViewRenderer> ViewRenderer::create(const PassDevice& device, const Config& config) {
  ViewRenderer made(device, config);
  auto memory = ViewBuffers::create(*device.gpu, config.size, config.passes);
  if (!memory) return memory.error();
  made.memory_ = std::move(*memory);
  if (auto step = made.create_commands(); !step) return step.error();
  auto descriptors = DescriptorSets::create(*device.gpu, *device.pipelines);
  if (!descriptors) return descriptors.error();
  made.descriptors_ = std::move(*descriptors);
  made.memory_.write_to(*device.gpu, made.descriptors_);
  if (config.passes == ViewPasses::kLight) made.bind_no_volume();
  return made;
}

Result<void> ViewRenderer::create_commands() {
  const VkCommandPoolCreateInfo pool_info{.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                          .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
                                          .queueFamilyIndex = device_.gpu->candidate().queue_family};
  VkCommandPool pool = VK_NULL_HANDLE;
  VkResult result = vkCreateCommandPool(device_.gpu->device(), &pool_info, nullptr, &pool);
  if (result != VK_SUCCESS) return vulkan_error("vkCreateCommandPool", result);
  command_pool_ = CommandPoolHandle(device_.gpu->device(), pool);

  std::array<VkCommandBuffer, 2> buffers{};
  const VkCommandBufferAllocateInfo buffer_info{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                                .commandPool = pool,
                                                .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                                .commandBufferCount = buffers.size()};
  result = vkAllocateCommandBuffers(device_.gpu->device(), &buffer_info, buffers.data());
  if (result != VK_SUCCESS) return vulkan_error("vkAllocateCommandBuffers", result);
  cast_commands_ = buffers[0];
  light_commands_ = buffers[1];
  set_debug_name(*device_.gpu, cast_commands_, "cast commands");
  set_debug_name(*device_.gpu, light_commands_, "light commands");

  auto clock = GpuTimestamps::create(*device_.gpu);
  if (!clock) return clock.error();
  timestamps_ = std::move(*clock);

  auto timeline = SubmissionTimeline::create(*device_.gpu, "view timeline");
  if (!timeline) return timeline.error();
  timeline_ = std::move(*timeline);
  return {};
}

void ViewRenderer::bind_no_volume() {
  descriptors_.write(*device_.gpu, FANLIGHT_BINDING_VOLUME, memory_.transfer);
  for (const auto& [binding, buffer] : FrameStore().bindings())
    descriptors_.write(*device_.gpu, binding, memory_.nothing);
  descriptors_.write(*device_.gpu, FANLIGHT_BINDING_ANGLE_TABLE, memory_.nothing);
}

void ViewRenderer::bind(const VolumeBindings& volume) {
  // As in ViewBuffers::write_to(), every descriptor must name something.
  const bool has_texture = volume.frames.texture().get() != VK_NULL_HANDLE;
  descriptors_.write(*device_.gpu, FANLIGHT_BINDING_VOLUME,
                     has_texture ? volume.frames.texture() : memory_.transfer);
  for (const auto& [binding, buffer] : volume.frames.bindings()) {
    descriptors_.write(*device_.gpu, binding, buffer != nullptr ? *buffer : memory_.nothing);
  }
  descriptors_.write(*device_.gpu, FANLIGHT_BINDING_ANGLE_TABLE, volume.angles.entries());
  other_work_ = volume.written.semaphore == timeline_.newest().semaphore ? TimelinePoint{} : volume.written;
}

void ViewRenderer::follow(const ViewRenderer& other) {
  descriptors_.write(*device_.gpu, FANLIGHT_BINDING_PREVIOUS_DEPTH, other.memory_.steady);
}

void ViewRenderer::copy_cast(const ViewRenderer& other, const VolumeBindings& volume) {
  bind(volume);
  farthest_mm_ = other.farthest_mm_;
  next_tile_ = cast_tiles_ = 0;
  confidence_known_ = other.confidence_known_;
  cast_since_light_ = true;
  reset_times();
  cast_to_copy_ = &other.memory_;
}

void ViewRenderer::take_cast(const ViewRenderer& other) {
  farthest_mm_ = other.farthest_mm_;
  confidence_known_ = other.confidence_known_;
  cast_since_light_ = true;
  reset_times();
  changed_ = changed_.united(memory_.take_cast(other.memory_, config_.size));
}

std::array<double, kStages> ViewRenderer::stage_ms() const {
  if (!config_.pauses) return timestamps_.ms(*device_.gpu);
  auto ms = done_ms_;
  ms[static_cast<std::size_t>(piece_stage_)] += timestamps_.piece_ms(*device_.gpu);
  return ms;
}

void ViewRenderer::reset_times() {
  const bool in_pieces = config_.pauses || config_.passes == ViewPasses::kLight;
  if (in_pieces && light_steps_.count() > 0 && light_steps_.submitted()) {
    const auto ms = stage_ms();
    // Steps over a part of the picture say nothing of whole ones.
    for (const Stage stage : {Stage::kFilter, Stage::kLight, Stage::kFinish}) {
      if (partly_) break;
      const auto index = static_cast<std::size_t>(stage);
      const auto steps = static_cast<double>(light_steps_.count_of(stage));
      if (ms[index] <= 0) continue;
      // With pauses between its pieces the filter of a main view takes longer than its steps do.
      double& step_ms = light_step_ms_[index];
      step_ms = config_.pauses || step_ms == 0 ? ms[index] / steps : std::min(step_ms, ms[index] / steps);
    }
  }
  timestamps_.reset(*device_.gpu);
  done_ms_ = {};
}

/// Begins to measure a piece of a view that pauses. Precondition there: the piece before it is done.
void ViewRenderer::begin_piece(VkCommandBuffer commands, Stage stage) {
  if (!config_.pauses) return;
  done_ms_ = stage_ms();
  timestamps_.reset_piece(*device_.gpu);
  piece_stage_ = stage;
  timestamps_.stamp(commands, GpuTimestamps::kPieceBegin);
}

void ViewRenderer::end_piece(VkCommandBuffer commands) const {
  if (config_.pauses) timestamps_.stamp(commands, GpuTimestamps::kPieceEnd);
}

Result<void> ViewRenderer::find_cast_pipelines(const Scene& scene, FrameKind kind) {
  const CastKeys keys = cast_keys(scene, kind, config_.skipping);
  const std::pair<VkPipeline*, std::optional<PipelineKey>> wanted[] = {
      {&cast_pipelines_.cast, keys.cast},
      {&cast_pipelines_.empty_space, keys.empty_space},
      {&cast_pipelines_.cast_listed, keys.cast_listed},
      {&cast_pipelines_.dirty_tiles, keys.dirty_tiles},
      {&cast_pipelines_.frame_steps, keys.frame_steps},
      {&cast_pipelines_.slice, keys.slice}};
  for (const auto& [pipeline, key] : wanted) {
    auto built = device_.pipelines->get(key);
    if (!built) return built.error();
    *pipeline = *built;
  }
  notes_reach_ = cast_pipelines_.dirty_tiles != VK_NULL_HANDLE;
  return {};
}

/// Cuts the picture into tiles and the tiles into bands.
void ViewRenderer::set_tiles(const Scene& scene, const shaders::CastParameters& parameters) {
  const std::uint64_t samples_across = std::uint64_t(scene.rays.window) * scene.rays.window;
  const std::uint64_t tile_samples =
      std::uint64_t{kTileSide} * kTileSide * samples_across * std::max(parameters.steps, 1U);
  const std::uint32_t tile_side = kTileSide * parameters.pixel_stride;
  cast_tiles_ = groups(config_.size.width, tile_side) * groups(config_.size.height, tile_side);
  const std::uint32_t most_groups = device_.gpu->limits().maxComputeWorkGroupCount[0];
  notes_reach_ = notes_reach_ && cast_tiles_ <= most_groups;  // a list of dirty tiles is not cut into bands
  const std::uint64_t most_tiles = std::min(cast_tiles_, most_groups);
  band_tiles_ = static_cast<std::uint32_t>(
      std::clamp<std::uint64_t>(config_.band_samples / tile_samples, 1, most_tiles));
}

Result<void> ViewRenderer::begin_cast(const Scene& wanted, const VolumeBindings& volume) {
  const Scene scene = effective_scene(wanted, volume.geometry, config_.size, volume.levels);
  if (auto found = find_cast_pipelines(scene, volume.geometry.kind); !found) return found;
  confidence_known_ = false;
  cast_to_copy_ = nullptr;

  // Memory that the GPU reads may be slow to read for the processor, so values that are needed again are
  // kept.
  const shaders::CastParameters parameters =
      cast_parameters(scene, config_.size, volume.geometry, volume.table, volume.extent);
  memory_.cast_parameters.mapped_as<shaders::CastParameters>() = parameters;
  farthest_mm_ = parameters.end;
  segments_in_ray_ = groups(parameters.steps, 1U << parameters.segment_shift);
  reset_times();
  set_tiles(scene, parameters);
  next_tile_ = 0;
  preparing_ = false;
  if (transferred_ != scene.transfer || transferred_step_mm_ != parameters.step) {
    transfer_due_ = true;  // also after a cast that is given up before its first band
    memory_.staged_transfer.mapped_as<TransferTable>() = transfer_table(scene.transfer, parameters.step);
    transferred_ = scene.transfer;
    transferred_step_mm_ = parameters.step;
  }
  cast_since_light_ = true;
  return {};
}

}  // namespace fanlight
