#include "renderer/render_slot.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "renderer/vulkan_result.hpp"
#include "shaders/bindings.h"
#include "shaders/prepare_constants.h"

namespace fanlight {

namespace {

// Time stamps, each before or after a stage; those of a stage that did not run are not written.
enum Query : std::uint32_t {
  kPrepareBegin,
  kPrepareEnd,
  kUploadEnd,
  kCastBegin,
  kCastEnd,
  kFilterBegin,
  kLightBegin,
  kLightEnd,
  kFinishEnd,
  kReadBackEnd,
  kQueries
};

// Group sizes of the shaders: tiles of 8 x 8 pixels; 8 rows or columns; 64 words by stretches of 64 rows.
constexpr std::uint32_t kTile = 8;
constexpr std::uint32_t kLines = 8;
constexpr std::uint32_t kWords = 64;
constexpr std::uint32_t kStretch = 64;

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

/// `row_texels`: from one row to the next in the buffer.
void copy_to_image(VkCommandBuffer commands, const GpuBuffer& from, const GpuImage& to,
                   std::uint32_t row_texels, std::uint32_t slices) {
  image_barrier(commands, to.get(), true);
  const VkBufferImageCopy all{.bufferRowLength = row_texels,
                              .imageSubresource = {.aspectMask = VK_IMAGE_ASPECT_COLOR_BIT, .layerCount = 1},
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
      {&staged_frames_, padded_frame_bytes() * config_.frame_capacity,
       VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, BufferPlace::kToGpu},
      {&staged_angles_, table_.entries().size_bytes(), VK_BUFFER_USAGE_TRANSFER_SRC_BIT, BufferPlace::kToGpu},
      {&staged_transfer_, sizeof(TransferTable), VK_BUFFER_USAGE_TRANSFER_SRC_BIT, BufferPlace::kToGpu},
      {&depth_, pixels * sizeof(float), kStorage, BufferPlace::kDevice},
      {&confidence_, pixels * sizeof(float), kStorage, BufferPlace::kDevice},
      {&volume_colour_, pixels * sizeof(std::uint32_t), kStorage, BufferPlace::kDevice},
      {&steady_, pixels * sizeof(float), kStorage, BufferPlace::kDevice},
      {&filled_, pixels * sizeof(float), kStorage, BufferPlace::kDevice},
      {&weights_, pixels * sizeof(std::uint32_t), kStorage, BufferPlace::kDevice},
      {&row_sums_, pixels * sizeof(glm::uvec2), kStorage, BufferPlace::kDevice},
      {&smooth_depth_, pixels * sizeof(float), kStorage, BufferPlace::kDevice},
      {&diffused_, pixels * sizeof(glm::uvec2), kStorage, BufferPlace::kDevice},
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
  auto angles = GpuImage::create(gpu, VK_FORMAT_R32_SFLOAT,
                                 {static_cast<std::uint32_t>(table_.entries().size()), 1, 1});
  if (!angles) return angles.error();
  angles_ = std::move(*angles);
  auto transfer = GpuImage::create(gpu, VK_FORMAT_R32G32B32A32_SFLOAT, {TransferTable().size(), 1, 1});
  if (!transfer) return transfer.error();
  transfer_ = std::move(*transfer);
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
  constexpr std::uint32_t kSets = std::tuple_size_v<decltype(descriptors_)>;
  const std::array<VkDescriptorPoolSize, 3> sizes = {
      {{VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 2 * kSets},
       {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 3 * kSets},
       {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, FANLIGHT_STORAGE_BUFFERS * kSets}}};
  const VkDescriptorPoolCreateInfo pool_info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                             .maxSets = kSets,
                                             .poolSizeCount = sizes.size(),
                                             .pPoolSizes = sizes.data()};
  VkDescriptorPool pool = VK_NULL_HANDLE;
  VkResult result = vkCreateDescriptorPool(gpu.device(), &pool_info, nullptr, &pool);
  if (result != VK_SUCCESS) return vulkan_error("vkCreateDescriptorPool", result);
  descriptor_pool_ = DescriptorPoolHandle(gpu.device(), pool);

  std::array<VkDescriptorSetLayout, kSets> layouts{};
  layouts.fill(passes.set_layout());
  const VkDescriptorSetAllocateInfo set_info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                             .descriptorPool = pool,
                                             .descriptorSetCount = kSets,
                                             .pSetLayouts = layouts.data()};
  result = vkAllocateDescriptorSets(gpu.device(), &set_info, descriptors_.data());
  if (result != VK_SUCCESS) return vulkan_error("vkAllocateDescriptorSets", result);

  const std::pair<std::uint32_t, const GpuBuffer*> buffers[] = {
      {FANLIGHT_BINDING_CAST_PARAMETERS, &cast_parameters_},
      {FANLIGHT_BINDING_LIGHT_PARAMETERS, &light_parameters_},
      // Until pass 0 is asked for there is no memory for it, and nothing reads or writes these.
      {FANLIGHT_BINDING_FRAMES, &depth_},
      {FANLIGHT_BINDING_COEFFICIENTS, &depth_},
      {FANLIGHT_BINDING_PREPARED, &depth_},
      {FANLIGHT_BINDING_DEPTH, &depth_},
      {FANLIGHT_BINDING_CONFIDENCE, &confidence_},
      {FANLIGHT_BINDING_VOLUME_COLOUR, &volume_colour_},
      {FANLIGHT_BINDING_PREVIOUS, &steady_},
      {FANLIGHT_BINDING_STEADY, &steady_},
      // Without islands, the depth map stands where the filtered one will.
      {FANLIGHT_BINDING_CLEANED, &smooth_depth_},
      {FANLIGHT_BINDING_FILLED, &filled_},
      {FANLIGHT_BINDING_WEIGHTS, &weights_},
      {FANLIGHT_BINDING_ROW_SUMS, &row_sums_},
      {FANLIGHT_BINDING_SMOOTH_DEPTH, &smooth_depth_},
      {FANLIGHT_BINDING_LIT, &row_sums_},
      {FANLIGHT_BINDING_DIFFUSED, &diffused_},
      {FANLIGHT_BINDING_FINISHED, &finished_}};
  for (const auto& [binding, buffer] : buffers) write_buffer(gpu, binding, *buffer);

  const std::pair<std::uint32_t, const GpuImage*> images[] = {{FANLIGHT_BINDING_VOLUME, &frames_},
                                                              {FANLIGHT_BINDING_ANGLE_TABLE, &angles_},
                                                              {FANLIGHT_BINDING_TRANSFER, &transfer_}};
  for (const auto& [binding, image] : images) {
    for (const VkDescriptorSet set : descriptors_) {
      const VkDescriptorImageInfo info{.imageView = image->view(),
                                       .imageLayout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
      const VkWriteDescriptorSet write{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                       .dstSet = set,
                                       .dstBinding = binding,
                                       .descriptorCount = 1,
                                       .descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                                       .pImageInfo = &info};
      vkUpdateDescriptorSets(gpu.device(), 1, &write, 0, nullptr);
    }
  }
  return {};
}

void RenderSlot::write_buffer(const Gpu& gpu, std::uint32_t binding, const GpuBuffer& buffer) const {
  const bool uniform =
      binding == FANLIGHT_BINDING_CAST_PARAMETERS || binding == FANLIGHT_BINDING_LIGHT_PARAMETERS;
  for (std::size_t set = 0; set < descriptors_.size(); ++set) {
    std::uint32_t place = binding;
    if (set == 1 && binding == FANLIGHT_BINDING_LIT) place = FANLIGHT_BINDING_DIFFUSED;
    if (set == 1 && binding == FANLIGHT_BINDING_DIFFUSED) place = FANLIGHT_BINDING_LIT;
    const VkDescriptorBufferInfo info{.buffer = buffer.get(), .range = VK_WHOLE_SIZE};
    const VkWriteDescriptorSet write{
        .sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
        .dstSet = descriptors_[set],
        .dstBinding = place,
        .descriptorCount = 1,
        .descriptorType = uniform ? VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER : VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
        .pBufferInfo = &info};
    vkUpdateDescriptorSets(gpu.device(), 1, &write, 0, nullptr);
  }
}

void RenderSlot::follow(const Gpu& gpu, const RenderSlot& other) {
  write_buffer(gpu, FANLIGHT_BINDING_PREVIOUS, other.steady_);
}

bool RenderSlot::fits_speckle_filter(const Gpu& gpu, const Scene::Speckle& speckle) const {
  if (speckle.filter == SpeckleFilter::kNone) return true;
  const bool guided = speckle.filter == SpeckleFilter::kGuided;
  return staged_frames_.bytes() <= gpu.limits().maxStorageBufferRange &&
         (!guided || frames_at_a_time(gpu, speckle) > 0);
}

std::uint64_t RenderSlot::frames_at_a_time(const Gpu& gpu, const Scene::Speckle& speckle) const {
  // More would save nothing: a dispatch over some frames keeps every GPU busy.
  constexpr std::uint64_t kMostBytes = 64 << 20;
  const std::uint64_t frame_bytes = padded_frame_bytes() * sizeof(std::uint32_t);
  const std::uint64_t beside = 2 * (static_cast<std::uint64_t>(speckle.across) / 2);
  const auto fitting = [&](std::uint64_t bytes) {
    const std::uint64_t frames = bytes / frame_bytes;
    return frames > beside ? std::min<std::uint64_t>(frames - beside, config_.frame_capacity) : 0;
  };
  const std::uint64_t limit = gpu.limits().maxStorageBufferRange;
  // Very large frames take what they need, one at a time.
  return std::max(fitting(std::min(limit, kMostBytes)), std::min<std::uint64_t>(fitting(limit), 1));
}

Result<void> RenderSlot::create_speckle_memory(const Gpu& gpu, const Scene::Speckle& speckle) {
  if (speckle.filter != SpeckleFilter::kNone && speckle_free_.bytes() == 0) {
    auto made = GpuBuffer::create(gpu, staged_frames_.bytes(),
                                  VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT,
                                  BufferPlace::kDevice);
    if (!made) return made.error();
    speckle_free_ = std::move(*made);
    write_buffer(gpu, FANLIGHT_BINDING_FRAMES, staged_frames_);
    write_buffer(gpu, FANLIGHT_BINDING_PREPARED, speckle_free_);
  }
  const std::uint64_t frames =
      frames_at_a_time(gpu, speckle) + 2 * (static_cast<std::uint64_t>(speckle.across) / 2);
  const std::uint64_t bytes = frames * padded_frame_bytes() * sizeof(std::uint32_t);
  if (speckle.filter == SpeckleFilter::kGuided && coefficients_.bytes() < bytes) {
    auto made = GpuBuffer::create(gpu, bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, BufferPlace::kDevice);
    if (!made) return made.error();
    coefficients_ = std::move(*made);
    write_buffer(gpu, FANLIGHT_BINDING_COEFFICIENTS, coefficients_);
  }
  return {};
}

void RenderSlot::load(const Volume& volume) {
  const auto staged = staged_frames_.mapped();
  const std::size_t columns = config_.geometry.columns;
  const std::size_t row_bytes = std::size_t{kPixelsInWord} * words_in_row();
  std::uint8_t* to = staged.data();
  for (const std::uint32_t index : volume.by_angle()) {
    const std::uint8_t* from = volume.frame_pixels(index).data();
    if (row_bytes == columns) {
      to = std::copy_n(from, padded_frame_bytes(), to);
      continue;
    }
    for (std::uint32_t row = 0; row < config_.geometry.rows; ++row, from += columns) {
      to = std::fill_n(std::copy_n(from, columns, to), row_bytes - columns, std::uint8_t{0});
    }
  }
  if (table_.place(volume)) {
    std::memcpy(staged_angles_.mapped().data(), table_.entries().data(), table_.entries().size_bytes());
  }
  volume_ = volume.stamp();
  extent_ = {.first_angle_rad = volume.angles_rad()[volume.by_angle().front()],
             .last_angle_rad = volume.angles_rad()[volume.by_angle().back()],
             .frames = volume_.frames,
             .frame_capacity = config_.frame_capacity};
  prepared_.reset();
}

void RenderSlot::stamp_time(VkCommandBuffer commands, std::uint32_t query) const {
  vkCmdWriteTimestamp2(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, times_.get(), query);
}

void RenderSlot::bind(VkCommandBuffer commands, const Passes& passes, std::size_t set) const {
  vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, passes.layout(), 0, 1, &descriptors_[set],
                          0, nullptr);
}

Result<void> RenderSlot::begin_cast(const Gpu& gpu, Passes& passes, const Scene& scene) {
  speckle_ = scene.speckle;
  filter_left_out_ = !fits_speckle_filter(gpu, speckle_);
  if (filter_left_out_) speckle_.filter = SpeckleFilter::kNone;
  if (!create_speckle_memory(gpu, speckle_)) {
    filter_left_out_ = true;
    speckle_.filter = SpeckleFilter::kNone;
  }
  speckle_pipelines_ = {};
  const std::pair<SpeckleFilter, Shader> speckle_shaders[] = {{SpeckleFilter::kBox, Shader::kBox},
                                                              {SpeckleFilter::kMedian, Shader::kMedian},
                                                              {SpeckleFilter::kGuided, Shader::kGuide},
                                                              {SpeckleFilter::kGuided, Shader::kGuided}};
  std::size_t half = 0;
  for (const auto& [filter, shader] : speckle_shaders) {
    if (filter != speckle_.filter) continue;
    auto pipeline = passes.speckle(shader, speckle_);
    if (!pipeline) return pipeline.error();
    speckle_pipelines_[half++] = *pipeline;
  }
  auto cast = passes.cast(scene, config_.geometry.kind);
  if (!cast) return cast.error();
  cast_pipeline_ = *cast;
  slice_pipeline_ = VK_NULL_HANDLE;
  if (scene.mode == Mode::kSlice || scene.mode == Mode::kSlices) {
    auto slice = passes.slice(config_.geometry.kind);
    if (!slice) return slice.error();
    slice_pipeline_ = *slice;
  }

  // Memory that the GPU reads may be slow to read here: what is needed of it is kept.
  const shaders::CastParameters parameters =
      cast_parameters(scene, config_.size, config_.geometry, table_, extent_);
  cast_parameters_.mapped_as<shaders::CastParameters>() = parameters;
  farthest_mm_ = parameters.end;
  vkResetQueryPool(gpu.device(), times_.get(), 0, kQueries);
  const std::uint64_t samples_across = std::uint64_t(scene.rays.window) * scene.rays.window;
  const std::uint64_t tile_samples =
      std::uint64_t{kTile} * kTile * samples_across * std::max(parameters.steps, 1U);
  const std::uint64_t most_tiles =
      std::min(tiles_across() * tiles_down(), gpu.limits().maxComputeWorkGroupCount[0]);
  band_tiles_ = static_cast<std::uint32_t>(
      std::clamp<std::uint64_t>(config_.band_samples / tile_samples, 1, most_tiles));
  next_tile_ = 0;
  volume_due_ = prepared_ != speckle_;
  next_frame_ = 0;
  if (transferred_ != scene.transfer || transferred_step_mm_ != parameters.step) {
    transfer_due_ = true;  // and stays so where a cast is given up before its first band
    staged_transfer_.mapped_as<TransferTable>() = transfer_table(scene.transfer, parameters.step);
    transferred_ = scene.transfer;
    transferred_step_mm_ = parameters.step;
  }
  cast_since_light_ = true;
  return {};
}

std::uint32_t RenderSlot::piece_of_volume(const Gpu& gpu) const {
  const bool guided = speckle_.filter == SpeckleFilter::kGuided;
  // What a pixel of each filter costs, in samples of pass 1, on lavapipe.
  const double window = double{1} * speckle_.size * speckle_.size;
  const double samples = speckle_.across * (guided                                      ? 3.5
                                            : speckle_.filter == SpeckleFilter::kMedian ? window / 3
                                                                                        : 1.5);
  const double frames =
      static_cast<double>(config_.band_samples) / (samples * static_cast<double>(padded_frame_bytes()));
  const std::uint64_t most = guided ? frames_at_a_time(gpu, speckle_) : volume_.frames;
  return static_cast<std::uint32_t>(std::clamp(frames, 1.0, static_cast<double>(most)));
}

void RenderSlot::record_speckle_filter(VkCommandBuffer commands, const Passes& passes, std::uint32_t first,
                                       std::uint32_t end) const {
  const bool guided = speckle_.filter == SpeckleFilter::kGuided;
  const std::uint32_t down = speckle_.filter == SpeckleFilter::kMedian
                                 ? config_.geometry.rows
                                 : groups(config_.geometry.rows, kStretch);
  const auto beside = static_cast<std::uint32_t>(speckle_.across / 2);
  shaders::PrepareConstants constants{.columns = config_.geometry.columns,
                                      .rows = config_.geometry.rows,
                                      .frames = volume_.frames,
                                      .first_kept = first - std::min(first, beside),
                                      .radius_across = speckle_.across / 2,
                                      .noise = static_cast<float>(speckle_.noise)};
  static_assert(sizeof constants <= Passes::kPushBytes);
  const auto filter = [&](VkPipeline pipeline, std::uint32_t from, std::uint32_t to) {
    constants.first_frame = from;
    vkCmdPushConstants(commands, passes.layout(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof constants,
                       &constants);
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
    vkCmdDispatch(commands, groups(words_in_row(), kWords), down, to - from);
    barrier(commands, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
            VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_COPY_BIT,
            VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT |
                VK_ACCESS_2_TRANSFER_READ_BIT);
  };
  if (guided) filter(speckle_pipelines_[0], constants.first_kept, std::min(end + beside, volume_.frames));
  filter(speckle_pipelines_[guided ? 1 : 0], first, end);
}

Result<void> RenderSlot::submit_volume(const Gpu& gpu, const Passes& passes) {
  const VkCommandBuffer commands = cast_commands_;
  if (auto begun = begin(commands); !begun) return begun;
  bind(commands, passes, 0);
  const bool filtered = speckle_.filter != SpeckleFilter::kNone;
  if (filtered) {
    if (next_frame_ == 0) stamp_time(commands, kPrepareBegin);
    const std::uint32_t end = std::min(next_frame_ + piece_of_volume(gpu), volume_.frames);
    record_speckle_filter(commands, passes, next_frame_, end);
    next_frame_ = end;
    if (end < volume_.frames) return submit(gpu.cast_queue(), commands);
  }
  stamp_time(commands, kPrepareEnd);
  copy_to_image(commands, filtered ? speckle_free_ : staged_frames_, frames_, kPixelsInWord * words_in_row(),
                volume_.frames);
  copy_to_image(commands, staged_angles_, angles_, angles_.extent().width, 1);
  stamp_time(commands, kUploadEnd);
  prepared_ = speckle_;
  volume_due_ = false;
  return submit(gpu.cast_queue(), commands);
}

Result<void> RenderSlot::cast_next_band(const Gpu& gpu, const Passes& passes) {
  if (volume_due_) return submit_volume(gpu, passes);
  const VkCommandBuffer commands = cast_commands_;
  if (auto begun = begin(commands); !begun) return begun;
  bind(commands, passes, 0);
  if (next_tile_ == 0) stamp_time(commands, kCastBegin);
  if (std::exchange(transfer_due_, false))
    copy_to_image(commands, staged_transfer_, transfer_, transfer_.extent().width, 1);
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, cast_pipeline_);
  vkCmdPushConstants(commands, passes.layout(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof next_tile_,
                     &next_tile_);
  const std::uint32_t tiles = std::min(band_tiles_, tiles_across() * tiles_down() - next_tile_);
  vkCmdDispatch(commands, tiles, 1, 1);
  next_tile_ += tiles;
  if (cast_submitted() && slice_pipeline_ != VK_NULL_HANDLE) {
    barrier(commands, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
            VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT);
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, slice_pipeline_);
    vkCmdDispatch(commands, tiles_across(), tiles_down(), 1);
  }
  if (cast_submitted()) stamp_time(commands, kCastEnd);
  return submit(gpu.cast_queue(), commands);
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
                        {passes.fixed(Shader::kIslands), tiles_across(), tiles_down()},
                        {passes.fixed(Shader::kHoles), tiles_across(), tiles_down()},
                        halves[0],
                        halves[1]};
  for (const Step& step : steps) {
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
    bind(commands, passes, static_cast<std::size_t>(step % 2));
    vkCmdDispatch(commands, tiles_across(), tiles_down(), 1);
    pass_barrier(commands);
  }
  bind(commands, passes, static_cast<std::size_t>(steps % 2));
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, passes.fixed(Shader::kFinish));
  vkCmdDispatch(commands, tiles_across(), tiles_down(), 1);
}

Result<void> RenderSlot::light(const Gpu& gpu, Passes& passes, const Scene& scene, Past past) {
  shaders::LightParameters parameters = light_parameters(scene, config_.size, farthest_mm_);
  if (past == Past::kNone) parameters.steady = 0;
  light_parameters_.mapped_as<shaders::LightParameters>() = parameters;
  const bool filter_due = cast_since_light_ || filter_ != scene.filter;
  filter_ = scene.filter;
  // A cast has reset all queries and may be writing its own now.
  if (!std::exchange(cast_since_light_, false)) vkResetQueryPool(gpu.device(), times_.get(), 0, kQueries);

  auto lit = passes.light(scene);
  if (!lit) return lit.error();
  const VkCommandBuffer commands = light_commands_;
  if (auto begun = begin(commands); !begun) return begun;
  // The other slot's filter may have come just before, and this one's may follow it.
  barrier(commands, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
          VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
          VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
          VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT);
  bind(commands, passes, 0);
  if (filter_due) {
    stamp_time(commands, kFilterBegin);
    if (auto recorded = record_depth_filter(commands, passes, scene); !recorded) return recorded;
  }
  stamp_time(commands, kLightBegin);
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, *lit);
  vkCmdDispatch(commands, tiles_across(), tiles_down(), 1);
  pass_barrier(commands);
  stamp_time(commands, kLightEnd);
  record_finish(commands, passes, scene);
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
  const GpuBuffer* const maps[] = {&depth_, &confidence_, &smooth_depth_};
  auto copy = GpuBuffer::create(gpu, std::size(maps) * depth_.bytes(), VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                                BufferPlace::kFromGpu);
  if (!copy) return copy.error();
  if (auto begun = begin(light_commands_); !begun) return begun.error();
  for (std::size_t map = 0; map < std::size(maps); ++map) {
    const VkBufferCopy region{.dstOffset = map * depth_.bytes(), .size = depth_.bytes()};
    vkCmdCopyBuffer(light_commands_, maps[map]->get(), copy->get(), 1, &region);
  }
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
  return DepthMaps{.cast_mm = map(0), .confidence = map(1), .smooth_mm = map(2)};
}

std::array<double, kStages> RenderSlot::stage_ms(const Gpu& gpu) const {
  std::array<std::uint64_t, kQueries> ticks{};
  const double ms_per_tick = gpu.limits().timestampPeriod / 1e6;
  const auto between = [&](Query from, Query to) {
    return ticks[to] > ticks[from] && ticks[from] > 0
               ? static_cast<double>(ticks[to] - ticks[from]) * ms_per_tick
               : 0.0;
  };
  // Queries that were not written since they were reset stay 0.
  for (std::uint32_t query = 0; query < kQueries; ++query) {
    vkGetQueryPoolResults(gpu.device(), times_.get(), query, 1, sizeof ticks[query], &ticks[query],
                          sizeof ticks[query], VK_QUERY_RESULT_64_BIT);
  }
  return {between(kPrepareBegin, kPrepareEnd), between(kPrepareEnd, kUploadEnd),
          between(kCastBegin, kCastEnd),       between(kFilterBegin, kLightBegin),
          between(kLightBegin, kLightEnd),     between(kLightEnd, kFinishEnd),
          between(kFinishEnd, kReadBackEnd)};
}

}  // namespace fanlight
