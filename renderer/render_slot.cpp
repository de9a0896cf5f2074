#include "renderer/render_slot.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
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

Result<RenderSlot> RenderSlot::create(const Gpu& gpu, const Passes& passes, const Config& config) {
  RenderSlot made(config);
  auto memory = SlotMemory::create(gpu, config.size, made.table_.entries().size_bytes());
  if (!memory) return memory.error();
  made.memory_ = std::move(*memory);
  if (auto step = made.create_frames(gpu, config.geometry, config.usual_frames); !step) return step.error();
  if (auto step = made.create_commands(gpu); !step) return step.error();
  if (auto step = made.create_descriptors(gpu, passes); !step) return step.error();
  return made;
}

Result<void> RenderSlot::create_frames(const Gpu& gpu, const FanGeometry& geometry, std::uint32_t frames) {
  auto made = FrameStore::create(gpu, {.columns = geometry.columns,
                                       .rows = geometry.rows,
                                       .frame_capacity = frames,
                                       .piece_samples = config_.band_samples,
                                       .sampling = config_.sampling});
  if (!made) return made.error();
  frames_ = std::move(*made);
  return {};
}

Result<void> RenderSlot::replace_frames(const Gpu& gpu, const Volume& volume) {
  frames_ = FrameStore();  // first, so that a volume as large as the GPU takes still has room
  // A motor's sweeps are not all of one length: with some room to spare the next longer one needs no memory.
  const std::uint32_t frames = volume.stamp().frames;
  const std::uint32_t roomy = std::min(frames + frames / 8, config_.frame_capacity);
  auto made = create_frames(gpu, volume.geometry(), std::max(frames, roomy));
  write_frame_descriptors(gpu);
  return made;
}

Result<void> RenderSlot::create_commands(const Gpu& gpu) {
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

Result<void> RenderSlot::create_descriptors(const Gpu& gpu, const Passes& passes) {
  auto made = DescriptorSets::create(gpu, passes);
  if (!made) return made.error();
  descriptors_ = std::move(*made);
  memory_.write_to(gpu, descriptors_);
  write_frame_descriptors(gpu);
  return {};
}

void RenderSlot::write_frame_descriptors(const Gpu& gpu) const {
  // A descriptor must name something that is there, also where no pipeline will use it: lavapipe looks at
  // all.
  const bool there = frames_.texture().get() != VK_NULL_HANDLE;
  descriptors_.write(gpu, FANLIGHT_BINDING_VOLUME, there ? frames_.texture() : memory_.transfer);
  for (const auto& [binding, buffer] : frames_.bindings()) {
    descriptors_.write(gpu, binding, buffer != nullptr ? *buffer : memory_.nothing);
  }
}

Result<void> RenderSlot::prepare(const Gpu& gpu, Passes& passes, const Scene& scene) {
  geometry_ = config_.geometry;
  if (auto begun = frames_.begin(gpu, passes, scene.speckle); !begun) return begun;
  write_frame_descriptors(gpu);
  return find_cast_pipelines(passes, scene);
}

Result<void> RenderSlot::find_cast_pipelines(Passes& passes, const Scene& scene) {
  // What is drawn with every frame will be drawn again in part.
  notes_reach_ = scene.refresh == Refresh::kFrame;
  auto cast = passes.cast(scene, geometry_.kind, config_.skipping,
                          notes_reach_ ? FANLIGHT_CAST_ALL_NOTED : FANLIGHT_CAST_ALL);
  if (!cast) return cast.error();
  cast_pipeline_ = *cast;
  auto segments = passes.segments(scene, geometry_.kind, config_.skipping);
  if (!segments) return segments.error();
  segments_pipeline_ = *segments;
  notes_reach_ = notes_reach_ && segments_pipeline_ != VK_NULL_HANDLE;
  if (notes_reach_) {
    // For recast(), where nobody should wait for a pipeline.
    auto listed = passes.cast(scene, geometry_.kind, config_.skipping, FANLIGHT_CAST_LISTED);
    if (!listed) return listed.error();
    if (auto changed = passes.changed(scene); !changed) return changed.error();
  }
  slice_pipeline_ = VK_NULL_HANDLE;
  if (scene.mode == Mode::kSlice || scene.mode == Mode::kSlices) {
    auto slice = passes.slice(geometry_.kind);
    if (!slice) return slice.error();
    slice_pipeline_ = *slice;
  }
  return {};
}

void RenderSlot::follow(const Gpu& gpu, const RenderSlot& other) {
  descriptors_.write(gpu, FANLIGHT_BINDING_PREVIOUS, other.memory_.steady);
}

Result<void> RenderSlot::load(const Gpu& gpu, const Volume& volume) {
  if (!frames_.suits(volume)) {
    if (auto made = replace_frames(gpu, volume); !made) return made;
  }
  frames_.load(volume);
  geometry_ = volume.geometry();
  angles_rad_.clear();
  for (const std::uint32_t index : volume.by_angle()) angles_rad_.push_back(volume.angles_rad()[index]);
  place_angles();
  volume_ = volume.stamp();
  return {};
}

void RenderSlot::place_angles() {
  if (table_.place(angles_rad_)) {
    std::memcpy(memory_.staged_angles.mapped().data(), table_.entries().data(),
                table_.entries().size_bytes());
    angles_due_ = true;
  }
  extent_ = {.first_angle_rad = angles_rad_.front(),
             .last_angle_rad = angles_rad_.back(),
             .frames = static_cast<std::uint32_t>(angles_rad_.size()),
             .frame_capacity = frames_.frame_capacity()};
}

void RenderSlot::stage(const FanGeometry& geometry, std::uint32_t place, std::uint32_t frames,
                       std::uint64_t arrival, std::span<const std::uint8_t> pixels) {
  if (!frames_.suits(geometry) || std::max(place + 1, frames) > frames_.frame_capacity()) return;
  frames_.stage(place, frames, arrival, pixels);
  frames_gone_ = true;
}

Result<bool> RenderSlot::prepare_ahead(const Gpu& gpu, Passes& passes, const Scene::Speckle& options) {
  if (!frames_gone_) return false;
  if (auto begun = frames_.begin(gpu, passes, options); !begun) return begun.error();
  if (frames_.bindings_changed()) write_frame_descriptors(gpu);
  if (!frames_.prepares_single_frames() || frames_.done()) return false;
  if (auto begun = begin_commands(cast_commands_); !begun) return begun.error();
  descriptors_.bind(cast_commands_, passes, Order::kLitToDiffused);
  frames_.record_piece(cast_commands_, passes);
  if (auto submitted = submit(gpu.cast_queue(), cast_commands_); !submitted) return submitted.error();
  return true;
}

Result<void> RenderSlot::begin_cast(const Gpu& gpu, Passes& passes, const Scene& scene) {
  if (auto begun = frames_.begin(gpu, passes, scene.speckle); !begun) return begun;
  if (frames_.bindings_changed()) write_frame_descriptors(gpu);
  if (auto found = find_cast_pipelines(passes, scene); !found) return found;
  confidence_known_ = false;
  frames_gone_ = false;
  changed_.reset();
  changed_beyond_ = false;

  // Memory that the GPU reads may be slow to read here: what is needed of it is kept.
  const shaders::CastParameters parameters = cast_parameters(scene, config_.size, geometry_, table_, extent_);
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

Result<void> RenderSlot::submit_frames(const Gpu& gpu, const Passes& passes) {
  const VkCommandBuffer commands = cast_commands_;
  if (auto begun = begin_commands(commands); !begun) return begun;
  descriptors_.bind(commands, passes, Order::kLitToDiffused);
  if (!std::exchange(preparing_, true)) clock_.stamp(commands, StageClock::kPrepareBegin);
  frames_.record_piece(commands, passes);
  if (frames_.done()) clock_.stamp(commands, StageClock::kPrepareEnd);
  return submit(gpu.cast_queue(), commands);
}

Result<void> RenderSlot::cast_next_band(const Gpu& gpu, const Passes& passes) {
  if (!frames_.done()) return submit_frames(gpu, passes);
  const VkCommandBuffer commands = cast_commands_;
  if (auto begun = begin_commands(commands); !begun) return begun;
  descriptors_.bind(commands, passes, Order::kLitToDiffused);
  if (next_tile_ == 0) record_before_rays(commands);
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

void RenderSlot::record_tables(VkCommandBuffer commands) {
  if (std::exchange(angles_due_, false)) {
    const VkBufferCopy all{.size = memory_.angles.bytes()};
    vkCmdCopyBuffer(commands, memory_.staged_angles.get(), memory_.angles.get(), 1, &all);
    barrier(commands, VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
            VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT);
  }
  if (std::exchange(transfer_due_, false))
    copy_to_image(commands, memory_.staged_transfer, memory_.transfer, {});
}

void RenderSlot::record_before_rays(VkCommandBuffer commands) {
  clock_.stamp(commands, StageClock::kUploadBegin);
  record_tables(commands);
  clock_.stamp(commands, StageClock::kCastBegin);
  if (notes_reach_) {
    vkCmdFillBuffer(commands, memory_.reached.get(), 0, VK_WHOLE_SIZE, 0);
    barrier(commands, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
            VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
            VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT);
  }
  record_segments(commands);
}

void RenderSlot::record_segments(VkCommandBuffer commands) const {
  if (segments_pipeline_ == VK_NULL_HANDLE) return;
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, segments_pipeline_);
  vkCmdDispatch(commands, groups(cast_tiles_, kLines), 1, 1);
  pass_barrier(commands);
}

void RenderSlot::record_slices(VkCommandBuffer commands) const {
  if (slice_pipeline_ == VK_NULL_HANDLE) return;
  barrier(commands, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
          VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT);
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, slice_pipeline_);
  vkCmdDispatch(commands, tiles_across(), tiles_down(), 1);
}

Result<void> RenderSlot::record_depth_filter(VkCommandBuffer commands, Passes& passes, const Scene& scene) {
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

void RenderSlot::record_finish(VkCommandBuffer commands, const Passes& passes, const Scene& scene) const {
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

Result<void> RenderSlot::light(const Gpu& gpu, Passes& passes, const Scene& scene, Past past) {
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
  if (by_confidence && !confidence_known_ && frames_gone_) {
    memory_.light_parameters.mapped_as<shaders::LightParameters>().confidence_counts = 0;
  } else if (by_confidence && !std::exchange(confidence_known_, true)) {
    auto confidence = passes.confidence(scene, geometry_.kind);
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

Result<void> RenderSlot::submit(VkQueue queue, VkCommandBuffer commands) {
  VkResult result = vkEndCommandBuffer(commands);
  if (result != VK_SUCCESS) return vulkan_error("vkEndCommandBuffer", result);
  const VkSemaphoreSubmitInfo after{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
                                    .semaphore = timeline_.get(),
                                    .value = submissions_,
                                    .stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT};
  const VkSemaphoreSubmitInfo done{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
                                   .semaphore = timeline_.get(),
                                   .value = submissions_ + 1,
                                   .stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT};
  const VkCommandBufferSubmitInfo buffer{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO,
                                         .commandBuffer = commands};
  const VkSubmitInfo2 info{.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2,
                           .waitSemaphoreInfoCount = 1,
                           .pWaitSemaphoreInfos = &after,
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

std::uint64_t RenderSlot::outstanding(const Gpu& gpu) const {
  std::uint64_t reached = 0;
  vkGetSemaphoreCounterValue(gpu.device(), timeline_.get(), &reached);
  return submissions_ - std::min(reached, submissions_);
}

Result<DepthMaps> RenderSlot::read_depth(const Gpu& gpu) {
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
