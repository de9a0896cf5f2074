#include "renderer/frame_store.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "renderer/command_recording.hpp"
#include "shaders/bindings.h"
#include "shaders/prepare_constants.h"

namespace fanlight {

namespace {

// Group sizes of pass 0's shaders: 64 words by stretches of 64 rows.
constexpr std::uint32_t kWords = 64;
constexpr std::uint32_t kStretch = 64;

Result<void> check_limits(const FrameStore::Config& config, const VkPhysicalDeviceLimits& limits) {
  if (std::max({config.columns, config.rows, config.frame_capacity}) <= limits.maxImageDimension3D) return {};
  return Error{ErrorCode::kUnsupported,
               fmt::format("a volume of {} x {} x {} is too large for this GPU, expected at most {} each way",
                           config.columns, config.rows, config.frame_capacity, limits.maxImageDimension3D)};
}

}  // namespace

Result<FrameStore> FrameStore::create(const Gpu& gpu, const Config& config) {
  if (auto fits = check_limits(config, gpu.limits()); !fits) return fits.error();
  FrameStore made;
  made.config_ = config;
  auto staged = GpuBuffer::create(gpu, made.frame_bytes() * config.frame_capacity,
                                  VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                                  BufferPlace::kToGpu);
  if (!staged) return staged.error();
  made.staged_ = std::move(*staged);
  auto texture =
      GpuImage::create(gpu, VK_FORMAT_R8_UNORM, {config.columns, config.rows, config.frame_capacity});
  if (!texture) return texture.error();
  made.texture_ = std::move(*texture);
  return made;
}

void FrameStore::load(const Volume& volume) {
  const auto staged = staged_.mapped();
  const std::size_t columns = config_.columns;
  const std::size_t row_bytes = std::size_t{kPixelsInWord} * words_in_row();
  std::uint8_t* to = staged.data();
  for (const std::uint32_t index : volume.by_angle()) {
    const std::uint8_t* from = volume.frame_pixels(index).data();
    if (row_bytes == columns) {
      to = std::copy_n(from, frame_bytes(), to);
      continue;
    }
    for (std::uint32_t row = 0; row < config_.rows; ++row, from += columns) {
      to = std::fill_n(std::copy_n(from, columns, to), row_bytes - columns, std::uint8_t{0});
    }
  }
  frames_ = volume.stamp().frames;
  next_frame_ = 0;
  prepared_.reset();
}

bool FrameStore::fits(const Gpu& gpu, const Scene::Speckle& options) const {
  if (options.filter == SpeckleFilter::kNone) return true;
  const bool guided = options.filter == SpeckleFilter::kGuided;
  return staged_.bytes() <= gpu.limits().maxStorageBufferRange &&
         (!guided || frames_at_a_time(gpu, options) > 0);
}

std::uint64_t FrameStore::frames_at_a_time(const Gpu& gpu, const Scene::Speckle& options) const {
  // More would save nothing: a dispatch over some frames keeps every GPU busy.
  constexpr std::uint64_t kMostBytes = 64 << 20;
  const std::uint64_t coefficient_bytes = frame_bytes() * sizeof(std::uint32_t);  // of a frame
  const std::uint64_t beside = 2 * (static_cast<std::uint64_t>(options.across) / 2);
  const auto fitting = [&](std::uint64_t bytes) {
    const std::uint64_t frames = bytes / coefficient_bytes;
    return frames > beside ? std::min<std::uint64_t>(frames - beside, config_.frame_capacity) : 0;
  };
  const std::uint64_t limit = gpu.limits().maxStorageBufferRange;
  // Very large frames take what they need, one at a time.
  return std::max(fitting(std::min(limit, kMostBytes)), std::min<std::uint64_t>(fitting(limit), 1));
}

Result<void> FrameStore::create_memory(const Gpu& gpu, const Scene::Speckle& options) {
  if (options.filter != SpeckleFilter::kNone && filtered_.bytes() == 0) {
    auto made = GpuBuffer::create(gpu, staged_.bytes(),
                                  VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT,
                                  BufferPlace::kDevice);
    if (!made) return made.error();
    filtered_ = std::move(*made);
    took_memory_ = true;
  }
  const std::uint64_t frames =
      frames_at_a_time(gpu, options) + 2 * (static_cast<std::uint64_t>(options.across) / 2);
  const std::uint64_t bytes = frames * frame_bytes() * sizeof(std::uint32_t);
  if (options.filter == SpeckleFilter::kGuided && coefficients_.bytes() < bytes) {
    auto made = GpuBuffer::create(gpu, bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, BufferPlace::kDevice);
    if (!made) return made.error();
    coefficients_ = std::move(*made);
    took_memory_ = true;
  }
  return {};
}

FrameStore::Bindings FrameStore::bindings() const {
  // Until a filter is asked for there is no memory for it, and nothing reads or writes what stands there.
  const bool there = filtered_.bytes() > 0;
  const bool guided = coefficients_.bytes() > 0;
  return {{{FANLIGHT_BINDING_FRAMES, there ? &staged_ : nullptr},
           {FANLIGHT_BINDING_PREPARED, there ? &filtered_ : nullptr},
           {FANLIGHT_BINDING_COEFFICIENTS, guided ? &coefficients_ : nullptr}}};
}

Result<void> FrameStore::find_pipelines(Passes& passes) {
  pipelines_ = {};
  const std::pair<SpeckleFilter, Shader> shaders[] = {{SpeckleFilter::kBox, Shader::kBox},
                                                      {SpeckleFilter::kMedian, Shader::kMedian},
                                                      {SpeckleFilter::kGuided, Shader::kGuide},
                                                      {SpeckleFilter::kGuided, Shader::kGuided}};
  std::size_t half = 0;
  for (const auto& [filter, shader] : shaders) {
    if (filter != wanted_.filter) continue;
    auto pipeline = passes.speckle(shader, wanted_);
    if (!pipeline) return pipeline.error();
    pipelines_[half++] = *pipeline;
  }
  return {};
}

Result<void> FrameStore::begin(const Gpu& gpu, Passes& passes, const Scene::Speckle& options) {
  const Scene::Speckle before = std::exchange(wanted_, options);
  took_memory_ = false;
  left_out_ = !fits(gpu, options) || !create_memory(gpu, options);
  if (left_out_) wanted_.filter = SpeckleFilter::kNone;
  if (wanted_ != before) next_frame_ = 0;
  piece_frames_ = piece_frames(gpu);
  return find_pipelines(passes);
}

std::uint32_t FrameStore::piece_frames(const Gpu& gpu) const {
  const bool guided = wanted_.filter == SpeckleFilter::kGuided;
  // What a pixel of each filter costs, in samples of pass 1, on lavapipe.
  const double window = double{1} * wanted_.size * wanted_.size;
  const double samples = wanted_.across * (guided                                     ? 3.5
                                           : wanted_.filter == SpeckleFilter::kMedian ? window / 3
                                                                                      : 1.5);
  const double frames =
      static_cast<double>(config_.piece_samples) / (samples * static_cast<double>(frame_bytes()));
  const std::uint64_t most = guided ? frames_at_a_time(gpu, wanted_) : frames_;
  return static_cast<std::uint32_t>(std::clamp(frames, 1.0, static_cast<double>(most)));
}

void FrameStore::record_filter(VkCommandBuffer commands, const Passes& passes) {
  if (!filters()) return;
  const std::uint32_t first = next_frame_;
  const std::uint32_t end = piece_end();
  const bool guided = wanted_.filter == SpeckleFilter::kGuided;
  const std::uint32_t down =
      wanted_.filter == SpeckleFilter::kMedian ? config_.rows : groups(config_.rows, kStretch);
  const auto beside = static_cast<std::uint32_t>(wanted_.across / 2);
  shaders::PrepareConstants constants{.columns = config_.columns,
                                      .rows = config_.rows,
                                      .frames = frames_,
                                      .first_kept = first - std::min(first, beside),
                                      .radius_across = wanted_.across / 2,
                                      .noise = static_cast<float>(wanted_.noise)};
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
  if (guided) filter(pipelines_[0], constants.first_kept, std::min(end + beside, frames_));
  filter(pipelines_[guided ? 1 : 0], first, end);
  next_frame_ = end;
}

void FrameStore::record_upload(VkCommandBuffer commands) {
  copy_to_image(commands, filters() ? filtered_ : staged_, texture_, kPixelsInWord * words_in_row(), frames_);
  prepared_ = wanted_;
}

}  // namespace fanlight
