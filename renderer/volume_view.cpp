#include "renderer/volume_view.hpp"

#include <algorithm>
#include <bit>
#include <functional>
#include <numeric>
#include <utility>

#include "proto/clock.hpp"
#include "renderer/command_recording.hpp"
#include "renderer/vulkan_result.hpp"
#include "shaders/bindings.h"

namespace fanlight {

namespace {

// Group sizes of the shaders: tiles of 8 x 8 pixels; 8 rows or columns.
constexpr std::uint32_t kTile = 8;
constexpr std::uint32_t kLines = 8;

constexpr float kFarthestMm = FANLIGHT_FARTHEST;

using Order = DescriptorSets::Order;

/// Each step of the diffusion leaves its picture where the next one reads.
Order order_after(int steps) {
  return steps % 2 == 0 ? Order::kLitToDiffused : Order::kDiffusedToLit;
}

}  // namespace

Result<VolumeView> VolumeView::create(const Gpu& gpu, const Passes& passes, const Config& config) {
  VolumeView made(config);
  auto memory = SlotMemory::create(gpu, config.size);
  if (!memory) return memory.error();
  made.memory_ = std::move(*memory);
  if (auto step = made.create_commands(gpu); !step) return step.error();
  auto descriptors = DescriptorSets::create(gpu, passes);
  if (!descriptors) return descriptors.error();
  made.descriptors_ = std::move(*descriptors);
  made.memory_.write_to(gpu, made.descriptors_);
  return made;
}

Result<void> VolumeView::create_commands(const Gpu& gpu) {
  const VkCommandPoolCreateInfo pool_info{.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                          .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
                                          .queueFamilyIndex = gpu.candidate().queue_family};
  VkCommandPool pool = VK_NULL_HANDLE;
  VkResult result = vkCreateCommandPool(gpu.device(), &pool_info, nullptr, &pool);
  if (result != VK_SUCCESS) return vulkan_error("vkCreateCommandPool", result);
  command_pool_ = CommandPoolHandle(gpu.device(), pool);

  std::array<VkCommandBuffer, 2> buffers{};
  const VkCommandBufferAllocateInfo buffer_info{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                                .commandPool = pool,
                                                .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                                .commandBufferCount = buffers.size()};
  result = vkAllocateCommandBuffers(gpu.device(), &buffer_info, buffers.data());
  if (result != VK_SUCCESS) return vulkan_error("vkAllocateCommandBuffers", result);
  cast_commands_ = buffers[0];
  light_commands_ = buffers[1];

  auto clock = StageClock::create(gpu);
  if (!clock) return clock.error();
  clock_ = std::move(*clock);

  const VkSemaphoreTypeCreateInfo type{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO,
                                       .semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE};
  const VkSemaphoreCreateInfo semaphore_info{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO,
                                             .pNext = &type};
  VkSemaphore timeline = VK_NULL_HANDLE;
  result = vkCreateSemaphore(gpu.device(), &semaphore_info, nullptr, &timeline);
  if (result != VK_SUCCESS) return vulkan_error("vkCreateSemaphore", result);
  timeline_ = SemaphoreHandle(gpu.device(), timeline);
  return {};
}

void VolumeView::see(const Gpu& gpu, const SeenVolume& volume) {
  // A descriptor must name something that is there, also where no pipeline will use it: lavapipe looks at
  // all.
  const bool there = volume.frames.texture().get() != VK_NULL_HANDLE;
  descriptors_.write(gpu, FANLIGHT_BINDING_VOLUME, there ? volume.frames.texture() : memory_.transfer);
  for (const auto& [binding, buffer] : volume.frames.bindings()) {
    descriptors_.write(gpu, binding, buffer != nullptr ? *buffer : memory_.nothing);
  }
  descriptors_.write(gpu, FANLIGHT_BINDING_ANGLE_TABLE, volume.angles.entries());
  memory_.write_cast_to(gpu, descriptors_);
  wait_for(volume);
}

void VolumeView::wait_for(const SeenVolume& volume) {
  others_timeline_ = volume.timeline == timeline_.get() ? VK_NULL_HANDLE : volume.timeline;
  others_submissions_ = volume.submissions;
}

void VolumeView::follow(const Gpu& gpu, const VolumeView& other) {
  descriptors_.write(gpu, FANLIGHT_BINDING_PREVIOUS, other.memory_.steady);
}

void VolumeView::share_cast(const Gpu& gpu, const VolumeView& other, const SeenVolume& volume) {
  see(gpu, volume);
  other.memory_.write_cast_to(gpu, descriptors_);
  farthest_mm_ = other.farthest_mm_;
  next_tile_ = cast_tiles_ = 0;
  confidence_known_ = false;
  cast_since_light_ = true;
  clock_.reset(gpu);
}

Result<void> VolumeView::find_cast_pipelines(Passes& passes, const Scene& scene, FrameKind kind) {
  // What is drawn with every frame will be drawn again in part.
  notes_reach_ = scene.refresh == Refresh::kFrame;
  auto cast =
      passes.cast(scene, kind, config_.skipping, notes_reach_ ? FANLIGHT_CAST_ALL_NOTED : FANLIGHT_CAST_ALL);
  if (!cast) return cast.error();
  cast_pipeline_ = *cast;
  auto segments = passes.segments(scene, kind, config_.skipping);
  if (!segments) return segments.error();
  segments_pipeline_ = *segments;
  notes_reach_ = notes_reach_ && segments_pipeline_ != VK_NULL_HANDLE;
  if (notes_reach_) {
    // For recast(), where nobody should wait for a pipeline.
    auto listed = passes.cast(scene, kind, config_.skipping, FANLIGHT_CAST_LISTED);
    if (!listed) return listed.error();
    if (auto changed = passes.changed(scene); !changed) return changed.error();
  }
  slice_pipeline_ = VK_NULL_HANDLE;
  if (scene.mode == Mode::kSlice || scene.mode == Mode::kSlices) {
    auto slice = passes.slice(kind);
    if (!slice) return slice.error();
    slice_pipeline_ = *slice;
  }
  return {};
}

Result<void> VolumeView::begin_cast(const Gpu& gpu, Passes& passes, const Scene& scene,
                                    const SeenVolume& volume) {
  if (auto found = find_cast_pipelines(passes, scene, volume.geometry.kind); !found) return found;
  confidence_known_ = false;

  // Memory that the GPU reads may be slow to read here: what is needed of it is kept.
  const shaders::CastParameters parameters =
      cast_parameters(scene, config_.size, volume.geometry, volume.table, volume.extent);
  memory_.cast_parameters.mapped_as<shaders::CastParameters>() = parameters;
  farthest_mm_ = parameters.end;
  segments_in_ray_ = groups(parameters.steps, 1U << parameters.segment_shift);
  clock_.reset(gpu);
  const std::uint64_t samples_across = std::uint64_t(scene.rays.window) * scene.rays.window;
  const std::uint64_t tile_samples =
      std::uint64_t{kTile} * kTile * samples_across * std::max(parameters.steps, 1U);
  const std::uint32_t tile_side = kTile * parameters.pixel_stride;
  cast_tiles_ = groups(config_.size.width, tile_side) * groups(config_.size.height, tile_side);
  const std::uint32_t most_groups = gpu.limits().maxComputeWorkGroupCount[0];
  notes_reach_ = notes_reach_ && cast_tiles_ <= most_groups;  // a list of tiles is not cut into bands
  const std::uint64_t most_tiles = std::min(cast_tiles_, most_groups);
  band_tiles_ = static_cast<std::uint32_t>(
      std::clamp<std::uint64_t>(config_.band_samples / tile_samples, 1, most_tiles));
  next_tile_ = 0;
  preparing_ = false;
  if (transferred_ != scene.transfer || transferred_step_mm_ != parameters.step) {
    transfer_due_ = true;  // and stays so where a cast is given up before its first band
    memory_.staged_transfer.mapped_as<TransferTable>() = transfer_table(scene.transfer, parameters.step);
    transferred_ = scene.transfer;
    transferred_step_mm_ = parameters.step;
  }
  cast_since_light_ = true;
  return {};
}

Result<void> VolumeView::prepare_ahead(const Gpu& gpu, const Passes& passes, const SeenVolume& volume) {
  if (auto begun = begin_commands(cast_commands_); !begun) return begun;
  descriptors_.bind(cast_commands_, passes, Order::kLitToDiffused);
  volume.frames.record_piece(cast_commands_, passes);
  return submit(gpu.cast_queue(), cast_commands_);
}

Result<void> VolumeView::submit_frames(const Gpu& gpu, const Passes& passes, const SeenVolume& volume) {
  const VkCommandBuffer commands = cast_commands_;
  if (auto begun = begin_commands(commands); !begun) return begun;
  descriptors_.bind(commands, passes, Order::kLitToDiffused);
  if (!std::exchange(preparing_, true)) clock_.stamp(commands, StageClock::kPrepareBegin);
  volume.frames.record_piece(commands, passes);
  if (volume.frames.done()) clock_.stamp(commands, StageClock::kPrepareEnd);
  return submit(gpu.cast_queue(), commands);
}

Result<void> VolumeView::cast_next_band(const Gpu& gpu, const Passes& passes, const SeenVolume& volume) {
  if (!volume.frames.done()) return submit_frames(gpu, passes, volume);
  const VkCommandBuffer commands = cast_commands_;
  if (auto begun = begin_commands(commands); !begun) return begun;
  descriptors_.bind(commands, passes, Order::kLitToDiffused);
  if (next_tile_ == 0) record_before_rays(commands, volume.angles);
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, cast_pipeline_);
  // Not as a push constant: lavapipe keeps a copy of the shader for each value that it sees.
  memory_.cast_parameters.mapped_as<shaders::CastParameters>().first_tile = next_tile_;
  const std::uint32_t tiles = std::min(band_tiles_, cast_tiles_ - next_tile_);
  vkCmdDispatch(commands, tiles, 1, 1);
  next_tile_ += tiles;
  if (cast_submitted()) record_slices(commands);
  if (cast_submitted()) clock_.stamp(commands, StageClock::kCastEnd);
  return submit(gpu.cast_queue(), commands);
}

Result<void> VolumeView::recast(const Gpu& gpu, Passes& passes, const Scene& scene, const SeenVolume& volume,
                                Places places) {
  auto listed = passes.cast(scene, volume.geometry.kind, config_.skipping, FANLIGHT_CAST_LISTED);
  if (!listed) return listed.error();
  auto changed = passes.changed(scene);
  if (!changed) return changed.error();
  clock_.reset(gpu);

  const VkCommandBuffer commands = cast_commands_;
  if (auto begun = begin_commands(commands); !begun) return begun;
  descriptors_.bind(commands, passes, Order::kLitToDiffused);
  clock_.stamp(commands, StageClock::kPrepareBegin);
  while (!volume.frames.done()) volume.frames.record_piece(commands, passes);
  clock_.stamp(commands, StageClock::kPrepareEnd);
  clock_.stamp(commands, StageClock::kUploadBegin);
  record_tables(commands, volume.angles);
  clock_.stamp(commands, StageClock::kCastBegin);
  record_changed_tiles(commands, passes, *changed, volume.frames, places);
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, *listed);
  vkCmdDispatchIndirect(commands, memory_.tile_list.get(), 0);
  record_slices(commands);
  clock_.stamp(commands, StageClock::kCastEnd);
  confidence_known_ = false;
  cast_since_light_ = true;
  return submit(gpu.cast_queue(), commands);
}

void VolumeView::record_tables(VkCommandBuffer commands, AngleBuffer& angles) {
  angles.record(commands);
  if (std::exchange(transfer_due_, false))
    copy_to_image(commands, memory_.staged_transfer, memory_.transfer, {});
}

void VolumeView::record_before_rays(VkCommandBuffer commands, AngleBuffer& angles) {
  clock_.stamp(commands, StageClock::kUploadBegin);
  record_tables(commands, angles);
  clock_.stamp(commands, StageClock::kCastBegin);
  if (notes_reach_) {
    vkCmdFillBuffer(commands, memory_.reached.get(), 0, VK_WHOLE_SIZE, 0);
    barrier(commands, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
            VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
            VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT);
  }
  record_segments(commands);
}

void VolumeView::record_segments(VkCommandBuffer commands) const {
  if (segments_pipeline_ == VK_NULL_HANDLE) return;
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, segments_pipeline_);
  vkCmdDispatch(commands, groups(cast_tiles_, kLines), 1, 1);
  pass_barrier(commands);
}

void VolumeView::record_slices(VkCommandBuffer commands) const {
  if (slice_pipeline_ == VK_NULL_HANDLE) return;
  barrier(commands, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
          VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT);
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, slice_pipeline_);
  vkCmdDispatch(commands, tiles_across(), tiles_down(), 1);
}

void VolumeView::record_changed_tiles(VkCommandBuffer commands, const Passes& passes, VkPipeline changed,
                                      const FrameStore& frames, Places places) const {
  constexpr std::array<std::uint32_t, 3> kNone = {0, 1, 1};
  const VkBufferCopy all{.size = memory_.segments.bytes()};
  vkCmdCopyBuffer(commands, memory_.segments.get(), memory_.old_segments.get(), 1, &all);
  vkCmdUpdateBuffer(commands, memory_.tile_list.get(), 0, sizeof kNone, kNone.data());
  barrier(commands, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
          VK_ACCESS_2_TRANSFER_WRITE_BIT | VK_ACCESS_2_TRANSFER_READ_BIT,
          VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
          VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT);
  record_segments(commands);
  // A filter across frames carries a frame into those beside it.
  const auto beside = static_cast<std::int32_t>(frames.reach_across());
  const std::array<std::int32_t, 2> range = {static_cast<std::int32_t>(places.first) - beside,
                                             static_cast<std::int32_t>(places.last) + beside};
  vkCmdPushConstants(commands, passes.layout(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof range, range.data());
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, changed);
  vkCmdDispatch(commands, groups(cast_tiles_, kLines), 1, 1);
  barrier(commands, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
          VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT,
          VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT |
              VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT);
}

Result<void> VolumeView::record_depth_filter(VkCommandBuffer commands, Passes& passes, const Scene& scene) {
  struct Step {
    VkPipeline pipeline;
    std::uint32_t groups_across;
    std::uint32_t groups_down;
  };
  std::array<Step, 2> halves = {
      {{passes.fixed(Shader::kMeanRows), groups(config_.size.height, kLines), 1},
       {passes.fixed(Shader::kMeanColumns), groups(config_.size.width, kLines), 1}}};
  if (scene.filter.kind != DepthFilter::kMean) {
    for (const auto axis : {Passes::Axis::kRows, Passes::Axis::kColumns}) {
      auto pipeline = passes.smooth(axis, scene.filter.kind);
      if (!pipeline) return pipeline.error();
      halves[static_cast<std::size_t>(axis)] = {*pipeline, tiles_across(), tiles_down()};
    }
  }
  const Step steps[] = {{passes.fixed(Shader::kSteady), tiles_across(), tiles_down()},
                        {passes.fixed(Shader::kTiles), groups(tiles_across() * tiles_down(), kLines), 1},
                        {passes.fixed(Shader::kUneven), groups(tiles_across() * tiles_down(), kLines), 1},
                        {passes.fixed(Shader::kIslands), tiles_across(), tiles_down()},
                        {confidence_pipeline_, tiles_across(), tiles_down()},
                        {passes.fixed(Shader::kHoles), tiles_across(), tiles_down()},
                        halves[0],
                        halves[1],
                        {passes.fixed(Shader::kNearest), groups(config_.size.height, kLines), 1}};
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

void VolumeView::record_finish(VkCommandBuffer commands, const Passes& passes, const Scene& scene) const {
  const int steps = scene.finish.smoothing == Smoothing::kDiffusion ? scene.finish.iterations : 0;
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, passes.fixed(Shader::kDiffuse));
  for (int step = 0; step < steps; ++step) {
    descriptors_.bind(commands, passes, order_after(step));
    vkCmdDispatch(commands, tiles_across(), tiles_down(), 1);
    pass_barrier(commands);
  }
  descriptors_.bind(commands, passes, order_after(steps));
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, passes.fixed(Shader::kFinish));
  vkCmdDispatch(commands, tiles_across(), tiles_down(), 1);
}

Result<void> VolumeView::light(const Gpu& gpu, Passes& passes, const Scene& scene, const SeenVolume& volume,
                               Past past) {
  shaders::LightParameters parameters = light_parameters(scene, config_.size, farthest_mm_);
  if (past == Past::kNone) parameters.steady = 0;
  memory_.light_parameters.mapped_as<shaders::LightParameters>() = parameters;
  const bool filter_due = cast_since_light_ || filter_ != scene.filter;
  filter_ = scene.filter;
  // A cast has reset all queries and may be writing its own now.
  if (!std::exchange(cast_since_light_, false)) clock_.reset(gpu);

  confidence_pipeline_ = VK_NULL_HANDLE;
  const bool by_confidence = scene.filter.weights == FilterWeights::kConfidence;
  // The next volume's picture will have it.
  if (by_confidence && !confidence_known_ && volume.frames_gone) {
    memory_.light_parameters.mapped_as<shaders::LightParameters>().confidence_counts = 0;
  } else if (by_confidence && !std::exchange(confidence_known_, true)) {
    auto confidence = passes.confidence(scene, volume.geometry.kind);
    if (!confidence) return confidence.error();
    confidence_pipeline_ = *confidence;
  }
  auto lit = passes.light(scene);
  if (!lit) return lit.error();
  const VkCommandBuffer commands = light_commands_;
  if (auto begun = begin_commands(commands); !begun) return begun;
  // The other slot's filter may have come just before, and this one's may follow it.
  barrier(commands, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
          VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
          VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
          VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT |
              VK_ACCESS_2_TRANSFER_WRITE_BIT);
  descriptors_.bind(commands, passes, Order::kLitToDiffused);
  if (filter_due) {
    clock_.stamp(commands, StageClock::kFilterBegin);
    if (auto recorded = record_depth_filter(commands, passes, scene); !recorded) return recorded;
  }
  clock_.stamp(commands, StageClock::kLightBegin);
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, *lit);
  vkCmdDispatch(commands, tiles_across(), tiles_down(), 1);
  pass_barrier(commands);
  clock_.stamp(commands, StageClock::kLightEnd);
  record_finish(commands, passes, scene);
  barrier(commands, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
          VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_READ_BIT);
  clock_.stamp(commands, StageClock::kFinishEnd);
  const VkBufferCopy all{.size = memory_.read_back.bytes()};
  vkCmdCopyBuffer(commands, memory_.finished.get(), memory_.read_back.get(), 1, &all);
  const VkBufferCopy depths{.size = memory_.read_back_depth.bytes()};
  vkCmdCopyBuffer(commands, memory_.smooth_depth.get(), memory_.read_back_depth.get(), 1, &depths);
  barrier(commands, VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
          VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT);
  clock_.stamp(commands, StageClock::kReadBackEnd);
  return submit(gpu.light_queue(), commands);
}

Result<void> VolumeView::submit(VkQueue queue, VkCommandBuffer commands) {
  VkResult result = vkEndCommandBuffer(commands);
  if (result != VK_SUCCESS) return vulkan_error("vkEndCommandBuffer", result);
  const VkSemaphoreSubmitInfo after[] = {{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
                                          .semaphore = timeline_.get(),
                                          .value = submissions_,
                                          .stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT},
                                         {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
                                          .semaphore = others_timeline_,
                                          .value = others_submissions_,
                                          .stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT}};
  const VkSemaphoreSubmitInfo done{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
                                   .semaphore = timeline_.get(),
                                   .value = submissions_ + 1,
                                   .stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT};
  const VkCommandBufferSubmitInfo buffer{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO,
                                         .commandBuffer = commands};
  const VkSubmitInfo2 info{.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2,
                           .waitSemaphoreInfoCount = others_timeline_ == VK_NULL_HANDLE ? 1U : 2U,
                           .pWaitSemaphoreInfos = after,
                           .commandBufferInfoCount = 1,
                           .pCommandBufferInfos = &buffer,
                           .signalSemaphoreInfoCount = 1,
                           .pSignalSemaphoreInfos = &done};
  result = vkQueueSubmit2(queue, 1, &info, VK_NULL_HANDLE);
  if (result != VK_SUCCESS) return vulkan_error("vkQueueSubmit2", result);
  ++submissions_;
  submitted_ns_ = now_ns();
  return {};
}

std::uint64_t VolumeView::outstanding(const Gpu& gpu) const {
  std::uint64_t reached = 0;
  vkGetSemaphoreCounterValue(gpu.device(), timeline_.get(), &reached);
  return submissions_ - std::min(reached, submissions_);
}

Result<DepthMaps> VolumeView::read_depth(const Gpu& gpu) {
  const GpuBuffer* const maps[] = {&memory_.depth, &memory_.confidence, &memory_.smooth_depth};
  const std::uint64_t maps_bytes = std::size(maps) * memory_.depth.bytes();
  auto copy = GpuBuffer::create(gpu, maps_bytes + memory_.segments.bytes(), VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                                BufferPlace::kFromGpu);
  if (!copy) return copy.error();
  if (auto begun = begin_commands(light_commands_); !begun) return begun.error();
  for (std::size_t map = 0; map < std::size(maps); ++map) {
    const VkBufferCopy region{.dstOffset = map * memory_.depth.bytes(), .size = memory_.depth.bytes()};
    vkCmdCopyBuffer(light_commands_, maps[map]->get(), copy->get(), 1, &region);
  }
  const VkBufferCopy region{.dstOffset = maps_bytes, .size = memory_.segments.bytes()};
  vkCmdCopyBuffer(light_commands_, memory_.segments.get(), copy->get(), 1, &region);
  barrier(light_commands_, VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
          VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT);
  if (auto submitted = submit(gpu.light_queue(), light_commands_); !submitted) return submitted.error();
  const VkSemaphore timeline = timeline_.get();
  const VkSemaphoreWaitInfo wait{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO,
                                 .semaphoreCount = 1,
                                 .pSemaphores = &timeline,
                                 .pValues = &submissions_};
  if (const VkResult result = vkWaitSemaphores(gpu.device(), &wait, UINT64_MAX); result != VK_SUCCESS) {
    return vulkan_error("vkWaitSemaphores", result);
  }
  const auto* values = reinterpret_cast<const float*>(copy->mapped().data());
  const auto map = [&](std::size_t index) {
    return std::vector<float>(values + index * pixels(), values + (index + 1) * pixels());
  };
  const auto* words = reinterpret_cast<const std::uint32_t*>(copy->mapped().data() + maps_bytes);
  const std::uint64_t sampled = std::transform_reduce(
      words, words + cast_tiles_ * sizeof(glm::uvec4) / sizeof *words, std::uint64_t{0}, std::plus(),
      [](std::uint32_t word) { return static_cast<std::uint64_t>(std::popcount(word)); });
  const auto segments = static_cast<double>(std::uint64_t{cast_tiles_} * segments_in_ray_);
  return DepthMaps{.cast_mm = map(0),
                   .confidence = confidence_known_ ? map(1) : std::vector<float>(),
                   .smooth_mm = map(2),
                   .sampled_share = segments_pipeline_ == VK_NULL_HANDLE
                                        ? 1
                                        : static_cast<double>(sampled) / std::max(segments, 1.0)};
}

}  // namespace fanlight
