#include "renderer/render_slot.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "renderer/vulkan_result.hpp"
#include "shaders/bindings.h"

namespace fanlight {

namespace {

// Time stamps: before the upload, after it, after pass 1; then before the filter and after each stage.
enum Query : std::uint32_t {
  kCastBegin,
  kUploadEnd,
  kCastEnd,
  kLightBegin,
  kFilterEnd,
  kLightEnd,
  kFinishEnd,
  kReadBackEnd,
  kQueries
};

constexpr std::uint32_t groups(std::uint32_t items, std::uint32_t of) {
  return (items + of - 1) / of;
}

void barrier(VkCommandBuffer commands, VkPipelineStageFlags2 from_stage, VkAccessFlags2 from_access,
             VkPipelineStageFlags2 to_stage, VkAccessFlags2 to_access) {
  const VkMemoryBarrier2 memory{.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
                                .srcStageMask = from_stage,
                                .srcAccessMask = from_access,
                                .dstStageMask = to_stage,
                                .dstAccessMask = to_access};
  const VkDependencyInfo dependency{
      .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .memoryBarrierCount = 1, .pMemoryBarriers = &memory};
  vkCmdPipelineBarrier2(commands, &dependency);
}

void pass_barrier(VkCommandBuffer commands) {
  barrier(commands, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
          VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_READ_BIT);
}

void image_barrier(VkCommandBuffer commands, VkImage image, bool before_copy) {
  const VkImageMemoryBarrier2 change{
      .sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
      .srcStageMask = before_copy ? VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT : VK_PIPELINE_STAGE_2_COPY_BIT,
      .srcAccessMask = before_copy ? VK_ACCESS_2_NONE : VK_ACCESS_2_TRANSFER_WRITE_BIT,
      .dstStageMask = before_copy ? VK_PIPELINE_STAGE_2_COPY_BIT : VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
      .dstAccessMask = before_copy ? VK_ACCESS_2_TRANSFER_WRITE_BIT : VK_ACCESS_2_SHADER_SAMPLED_READ_BIT,
      // The copy replaces all that is read afterwards, so what was there may go.
      .oldLayout = before_copy ? VK_IMAGE_LAYOUT_UNDEFINED : VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
      .newLayout =
          before_copy ? VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL : VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
      .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
      .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
      .image = image,
      .subresourceRange = {.aspectMask = VK_IMAGE_ASPECT_COLOR_BIT, .levelCount = 1, .layerCount = 1}};
  const VkDependencyInfo dependency{.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
                                    .imageMemoryBarrierCount = 1,
                                    .pImageMemoryBarriers = &change};
  vkCmdPipelineBarrier2(commands, &dependency);
}

void copy_to_image(VkCommandBuffer commands, const GpuBuffer& from, const GpuImage& to,
                   std::uint32_t slices) {
  image_barrier(commands, to.get(), true);
  const VkBufferImageCopy all{.imageSubresource = {.aspectMask = VK_IMAGE_ASPECT_COLOR_BIT, .layerCount = 1},
                              .imageExtent = {to.extent().width, to.extent().height, slices}};
  vkCmdCopyBufferToImage(commands, from.get(), to.get(), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &all);
  image_barrier(commands, to.get(), false);
}

Result<void> begin(VkCommandBuffer commands) {
  const VkCommandBufferBeginInfo info{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                      .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
  const VkResult result = vkBeginCommandBuffer(commands, &info);
  if (result != VK_SUCCESS) return vulkan_error("vkBeginCommandBuffer", result);
  return {};
}

}  // namespace

Result<RenderSlot> RenderSlot::create(const Gpu& gpu, const Passes& passes, const Config& config) {
  RenderSlot made(config);
  if (auto step = made.create_memory(gpu); !step) return step.error();
  if (auto step = made.create_commands(gpu); !step) return step.error();
  if (auto step = made.create_descriptors(gpu, passes); !step) return step.error();
  return made;
}

Result<void> RenderSlot::create_memory(const Gpu& gpu) {
  const FanGeometry& geometry = config_.geometry;
  const std::uint64_t pixels = std::uint64_t{config_.size.width} * config_.size.height;
  constexpr VkBufferUsageFlags kStorage =
      VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT;

  struct Wanted {
    GpuBuffer* buffer;
    std::uint64_t bytes;
    VkBufferUsageFlags usage;
    BufferPlace place;
  };
  const Wanted buffers[] = {
      {&cast_parameters_, sizeof(shaders::CastParameters), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT,
       BufferPlace::kToGpu},
      {&light_parameters_, sizeof(shaders::LightParameters), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT,
       BufferPlace::kToGpu},
      {&staged_frames_, geometry.frame_bytes() * config_.frame_capacity, VK_BUFFER_USAGE_TRANSFER_SRC_BIT,
       BufferPlace::kToGpu},
      {&staged_table_, table_.texels().size_bytes(), VK_BUFFER_USAGE_TRANSFER_SRC_BIT, BufferPlace::kToGpu},
      {&depth_, pixels * sizeof(float), kStorage, BufferPlace::kDevice},
      {&volume_colour_, pixels * sizeof(std::uint32_t), kStorage, BufferPlace::kDevice},
      {&row_sums_, pixels * sizeof(glm::uvec2), kStorage, BufferPlace::kDevice},
      {&smooth_depth_, pixels * sizeof(float), kStorage, BufferPlace::kDevice},
      {&lit_, pixels * sizeof(std::uint32_t), kStorage, BufferPlace::kDevice},
      {&finished_, pixels * sizeof(std::uint32_t), kStorage, BufferPlace::kDevice},
      {&read_back_, pixels * sizeof(std::uint32_t), VK_BUFFER_USAGE_TRANSFER_DST_BIT, BufferPlace::kFromGpu},
  };
  for (const Wanted& wanted : buffers) {
    auto buffer = GpuBuffer::create(gpu, wanted.bytes, wanted.usage, wanted.place);
    if (!buffer) return buffer.error();
    *wanted.buffer = std::move(*buffer);
  }

  auto frames =
      GpuImage::create(gpu, VK_FORMAT_R8_UNORM, {geometry.columns, geometry.rows, config_.frame_capacity});
  if (!frames) return frames.error();
  frames_ = std::move(*frames);
  auto table = GpuImage::create(gpu, VK_FORMAT_R32G32_SFLOAT, {table_.width(), table_.height(), 1});
  if (!table) return table.error();
  fan_table_ = std::move(*table);
  return {};
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

  const VkQueryPoolCreateInfo query_info{.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
                                         .queryType = VK_QUERY_TYPE_TIMESTAMP,
                                         .queryCount = kQueries};
  VkQueryPool times = VK_NULL_HANDLE;
  result = vkCreateQueryPool(gpu.device(), &query_info, nullptr, &times);
  if (result != VK_SUCCESS) return vulkan_error("vkCreateQueryPool", result);
  times_ = QueryPoolHandle(gpu.device(), times);

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
  const std::array<VkDescriptorPoolSize, 3> sizes = {{{VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 2},
                                                      {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 2},
                                                      {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 6}}};
  const VkDescriptorPoolCreateInfo pool_info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                             .maxSets = 1,
                                             .poolSizeCount = sizes.size(),
                                             .pPoolSizes = sizes.data()};
  VkDescriptorPool pool = VK_NULL_HANDLE;
  VkResult result = vkCreateDescriptorPool(gpu.device(), &pool_info, nullptr, &pool);
  if (result != VK_SUCCESS) return vulkan_error("vkCreateDescriptorPool", result);
  descriptor_pool_ = DescriptorPoolHandle(gpu.device(), pool);

  const VkDescriptorSetLayout layout = passes.set_layout();
  const VkDescriptorSetAllocateInfo set_info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                             .descriptorPool = pool,
                                             .descriptorSetCount = 1,
                                             .pSetLayouts = &layout};
  result = vkAllocateDescriptorSets(gpu.device(), &set_info, &descriptors_);
  if (result != VK_SUCCESS) return vulkan_error("vkAllocateDescriptorSets", result);

  const auto write_buffer = [&](std::uint32_t binding, VkDescriptorType type, const GpuBuffer& buffer) {
    const VkDescriptorBufferInfo info{.buffer = buffer.get(), .range = VK_WHOLE_SIZE};
    const VkWriteDescriptorSet write{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                     .dstSet = descriptors_,
                                     .dstBinding = binding,
                                     .descriptorCount = 1,
                                     .descriptorType = type,
                                     .pBufferInfo = &info};
    vkUpdateDescriptorSets(gpu.device(), 1, &write, 0, nullptr);
  };
  const auto write_image = [&](std::uint32_t binding, const GpuImage& image) {
    const VkDescriptorImageInfo info{.imageView = image.view(),
                                     .imageLayout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    const VkWriteDescriptorSet write{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                     .dstSet = descriptors_,
                                     .dstBinding = binding,
                                     .descriptorCount = 1,
                                     .descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                                     .pImageInfo = &info};
    vkUpdateDescriptorSets(gpu.device(), 1, &write, 0, nullptr);
  };
  write_buffer(FANLIGHT_BINDING_CAST_PARAMETERS, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, cast_parameters_);
  write_buffer(FANLIGHT_BINDING_LIGHT_PARAMETERS, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, light_parameters_);
  write_image(FANLIGHT_BINDING_VOLUME, frames_);
  write_image(FANLIGHT_BINDING_FAN_TABLE, fan_table_);
  const std::pair<std::uint32_t, const GpuBuffer*> storage[] = {
      {FANLIGHT_BINDING_DEPTH, &depth_},       {FANLIGHT_BINDING_VOLUME_COLOUR, &volume_colour_},
      {FANLIGHT_BINDING_ROW_SUMS, &row_sums_}, {FANLIGHT_BINDING_SMOOTH_DEPTH, &smooth_depth_},
      {FANLIGHT_BINDING_LIT, &lit_},           {FANLIGHT_BINDING_FINISHED, &finished_}};
  for (const auto& [binding, buffer] : storage) {
    write_buffer(binding, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, *buffer);
  }
  return {};
}

void RenderSlot::load(const Volume& volume) {
  const auto staged = staged_frames_.mapped();
  const std::size_t frame_bytes = config_.geometry.frame_bytes();
  std::size_t place = 0;
  for (const std::uint32_t index : volume.by_angle()) {
    std::memcpy(staged.data() + place * frame_bytes, volume.frame_pixels(index).data(), frame_bytes);
    ++place;
  }
  if (table_.place(volume)) {
    std::memcpy(staged_table_.mapped().data(), table_.texels().data(), table_.texels().size_bytes());
    table_staged_ = true;
  }
  volume_ = volume.stamp();
  extent_ = {.first_angle_rad = volume.angles_rad()[volume.by_angle().front()],
             .last_angle_rad = volume.angles_rad()[volume.by_angle().back()],
             .frames = volume_.frames,
             .frame_capacity = config_.frame_capacity};
  frames_staged_ = true;
}

void RenderSlot::stamp_time(VkCommandBuffer commands, std::uint32_t query) const {
  vkCmdWriteTimestamp2(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, times_.get(), query);
}

void RenderSlot::record_upload(VkCommandBuffer commands) {
  if (frames_staged_) copy_to_image(commands, staged_frames_, frames_, volume_.frames);
  if (table_staged_) copy_to_image(commands, staged_table_, fan_table_, 1);
  frames_staged_ = false;
  table_staged_ = false;
}

void RenderSlot::begin_cast(const Gpu& gpu, VkPipeline pass1, const Scene& scene) {
  cast_parameters_.mapped_as<shaders::CastParameters>() =
      cast_parameters(scene, config_.size, config_.geometry, table_, extent_);
  vkResetQueryPool(gpu.device(), times_.get(), 0, kQueries);
  pass1_ = pass1;
  const auto& parameters = cast_parameters_.mapped_as<shaders::CastParameters>();
  const std::uint64_t tile_samples = std::uint64_t{64} * std::max(parameters.steps, 1U);
  const std::uint64_t most_tiles =
      std::min(tiles_across() * tiles_down(), gpu.limits().maxComputeWorkGroupCount[0]);
  band_tiles_ = static_cast<std::uint32_t>(
      std::clamp<std::uint64_t>(config_.band_samples / tile_samples, 1, most_tiles));
  next_tile_ = 0;
  cast_since_light_ = true;
}

Result<void> RenderSlot::cast_next_band(const Gpu& gpu, const Passes& passes) {
  const VkCommandBuffer commands = cast_commands_;
  if (auto begun = begin(commands); !begun) return begun;
  if (next_tile_ == 0) {
    stamp_time(commands, kCastBegin);
    record_upload(commands);
    stamp_time(commands, kUploadEnd);
  }
  vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, passes.layout(), 0, 1, &descriptors_, 0,
                          nullptr);
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pass1_);
  vkCmdPushConstants(commands, passes.layout(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof next_tile_,
                     &next_tile_);
  const std::uint32_t tiles = std::min(band_tiles_, tiles_across() * tiles_down() - next_tile_);
  vkCmdDispatch(commands, tiles, 1, 1);
  next_tile_ += tiles;
  if (cast_submitted()) stamp_time(commands, kCastEnd);
  return submit(gpu.cast_queue(), commands);
}

Result<void> RenderSlot::light(const Gpu& gpu, const Passes& passes, const Scene& scene) {
  light_parameters_.mapped_as<shaders::LightParameters>() = light_parameters(scene, config_.size);
  timed_cast_ = std::exchange(cast_since_light_, false);
  // A cast has reset all queries and may be writing its own now.
  if (!timed_cast_) vkResetQueryPool(gpu.device(), times_.get(), 0, kQueries);

  const VkCommandBuffer commands = light_commands_;
  if (auto begun = begin(commands); !begun) return begun;
  vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, passes.layout(), 0, 1, &descriptors_, 0,
                          nullptr);
  stamp_time(commands, kLightBegin);
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, passes.filter_rows());
  vkCmdDispatch(commands, groups(config_.size.height, 8), 1, 1);
  pass_barrier(commands);
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, passes.filter_columns());
  vkCmdDispatch(commands, groups(config_.size.width, 8), 1, 1);
  pass_barrier(commands);
  stamp_time(commands, kFilterEnd);
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, passes.light());
  vkCmdDispatch(commands, tiles_across(), tiles_down(), 1);
  pass_barrier(commands);
  stamp_time(commands, kLightEnd);
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, passes.finish());
  vkCmdDispatch(commands, tiles_across(), tiles_down(), 1);
  barrier(commands, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
          VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_READ_BIT);
  stamp_time(commands, kFinishEnd);
  const VkBufferCopy all{.size = read_back_.bytes()};
  vkCmdCopyBuffer(commands, finished_.get(), read_back_.get(), 1, &all);
  barrier(commands, VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
          VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT);
  stamp_time(commands, kReadBackEnd);
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
  return {};
}

std::uint64_t RenderSlot::outstanding(const Gpu& gpu) const {
  std::uint64_t reached = 0;
  vkGetSemaphoreCounterValue(gpu.device(), timeline_.get(), &reached);
  return submissions_ - std::min(reached, submissions_);
}

Result<DepthMaps> RenderSlot::read_depth(const Gpu& gpu) {
  auto copy =
      GpuBuffer::create(gpu, 2 * depth_.bytes(), VK_BUFFER_USAGE_TRANSFER_DST_BIT, BufferPlace::kFromGpu);
  if (!copy) return copy.error();
  if (auto begun = begin(light_commands_); !begun) return begun.error();
  const VkBufferCopy first{.size = depth_.bytes()};
  const VkBufferCopy second{.dstOffset = depth_.bytes(), .size = depth_.bytes()};
  vkCmdCopyBuffer(light_commands_, depth_.get(), copy->get(), 1, &first);
  vkCmdCopyBuffer(light_commands_, smooth_depth_.get(), copy->get(), 1, &second);
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
  const std::size_t pixels = std::size_t{config_.size.width} * config_.size.height;
  return DepthMaps{.cast_mm = {values, values + pixels}, .smooth_mm = {values + pixels, values + 2 * pixels}};
}

std::array<double, kStages> RenderSlot::stage_ms(const Gpu& gpu) const {
  std::array<std::uint64_t, kQueries> ticks{};
  const std::uint32_t first = timed_cast_ ? kCastBegin : kLightBegin;
  vkGetQueryPoolResults(gpu.device(), times_.get(), first, kQueries - first,
                        sizeof(std::uint64_t) * (kQueries - first), &ticks[first], sizeof(std::uint64_t),
                        VK_QUERY_RESULT_64_BIT);
  const double ms_per_tick = gpu.limits().timestampPeriod / 1e6;
  const auto between = [&](Query from, Query to) {
    return ticks[to] > ticks[from] ? static_cast<double>(ticks[to] - ticks[from]) * ms_per_tick : 0.0;
  };
  return {timed_cast_ ? between(kCastBegin, kUploadEnd) : 0,
          timed_cast_ ? between(kUploadEnd, kCastEnd) : 0,
          between(kLightBegin, kFilterEnd),
          between(kFilterEnd, kLightEnd),
          between(kLightEnd, kFinishEnd),
          between(kFinishEnd, kReadBackEnd)};
}

}  // namespace fanlight
