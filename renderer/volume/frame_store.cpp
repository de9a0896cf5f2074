// SPDX-License-Identifier: Apache-2.0
#include "renderer/volume/frame_store.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "renderer/vulkan/command_recording.hpp"
#include "shaders/bindings.h"
#include "shaders/prepare_constants.h"

namespace fanlight {

namespace {

// Group sizes of pass 0's shaders: 64 words of a row, and runs of 64 rows.
constexpr std::uint32_t kWordsInGroup = 64;
constexpr std::uint32_t kRowsInGroup = 64;

constexpr std::uint32_t blocks_along(std::uint32_t pixels) {
  return groups(pixels, FANLIGHT_BLOCK);
}

// Buffers that shaders read, or write and read, as texels.
constexpr VkBufferUsageFlags kTexels = VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT;
constexpr VkBufferUsageFlags kWrittenTexels = kTexels | VK_BUFFER_USAGE_STORAGE_TEXEL_BUFFER_BIT;

Result<void> check_limits(const FrameStore::Config& config, const VkPhysicalDeviceLimits& limits) {
  if (config.sampling == Sampling::kGathering) return {};  // GpuBuffer checks its own limits
  if (std::max({config.columns, config.rows, config.frame_capacity}) <= limits.maxImageDimension3D) return {};
  return Error{ErrorCode::kUnsupported,
               fmt::format("a volume of {} x {} x {} is too large for this GPU, expected at most {} each way",
                           config.columns, config.rows, config.frame_capacity, limits.maxImageDimension3D)};
}

}  // namespace

Result<FrameStore> FrameStore::create(const PassDevice& device, const Config& config) {
  const Gpu& gpu = *device.gpu;
  if (auto fits = check_limits(config, gpu.limits()); !fits) return fits.error();
  FrameStore made;
  made.device_ = device;
  made.config_ = config;
  made.commit_numbers_.resize(config.frame_capacity);
  made.prepared_.resize(config.frame_capacity);
  auto staged =
      GpuBuffer::create(gpu, "staged frames", made.frame_bytes() * config.frame_capacity,
                        kTexels | VK_BUFFER_USAGE_TRANSFER_SRC_BIT, BufferPlace::kToGpu, VK_FORMAT_R32_UINT);
  if (!staged) return staged.error();
  made.staged_ = std::move(*staged);
  if (auto min_max = made.create_min_max(); !min_max) return min_max.error();
  if (auto volume = made.create_volume(); !volume) return volume.error();
  if (made.is_prepared_here()) {
    for (std::size_t thread = 0; thread < config.workers->threads(); ++thread)
      made.preparers_.emplace_back(config.columns);
  }
  return made;
}

Result<void> FrameStore::create_min_max() {
  const auto create = [&](GpuBuffer& buffer, const char* name, BufferPlace place) -> Result<void> {
    auto made =
        GpuBuffer::create(*device_.gpu, name, bounds_words() * config_.frame_capacity * sizeof(std::uint32_t),
                          VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | kTexels, place, VK_FORMAT_R32_UINT);
    if (!made) return made.error();
    buffer = std::move(*made);
    return {};
  };
  if (is_prepared_here()) return create(bounds_, "bounds", BufferPlace::kToGpu);
  if (auto blocks = create(blocks_, "blocks", BufferPlace::kDevice); !blocks) return blocks;
  return create(bounds_, "bounds", BufferPlace::kDevice);
}

Result<void> FrameStore::create_volume() {
  const Gpu& gpu = *device_.gpu;
  if (config_.sampling == Sampling::kTexture) {
    auto texture = GpuImage::create(gpu, "volume", VK_FORMAT_R8_UNORM,
                                    {config_.columns, config_.rows, std::max(config_.frame_capacity, 2U)});
    if (!texture) return texture.error();
    texture_ = std::move(*texture);
    return {};
  }
  // One frame more: values that are interpolated with weight 0, behind the last frame or after its last
  // column, must be readable.
  const std::uint64_t words = packed_words() * (std::uint64_t{config_.frame_capacity} + 1);
  auto packed = GpuBuffer::create(gpu, "packed frames", words * sizeof(std::uint32_t), kTexels,
                                  BufferPlace::kToGpu, VK_FORMAT_R32_UINT);
  if (!packed) return packed.error();
  packed_ = std::move(*packed);
  return {};
}

std::uint64_t FrameStore::packed_words() const {
  return std::uint64_t{FANLIGHT_PACKED_STRIDE(config_.columns)} * FANLIGHT_PACKED_ROWS(config_.rows);
}

std::uint64_t FrameStore::bounds_words() const {
  return std::uint64_t{blocks_along(config_.columns)} * blocks_along(config_.rows);
}

void FrameStore::set_frame_count(std::uint32_t frames) {
  // A filter across frames reads neighbours, of which there are fewer at both ends.
  if (frames != frames_ && !prepares_single_frames()) prepared_.assign(prepared_.size(), false);
  frames_ = frames;
}

void FrameStore::load(const Volume& volume) {
  thread_owner_.check();
  left_out_ = false;  // the memory that was missing may be there now
  set_frame_count(volume.stamp().frames);
  const auto order = volume.by_angle();
  for (std::uint32_t frame_index = 0; frame_index < frames_; ++frame_index) {
    const std::uint64_t commit_number = volume.commit_numbers()[order[frame_index]];
    if (holds(frame_index, commit_number)) continue;
    copy_frame(frame_index, commit_number, volume.frame_pixels(order[frame_index]));
  }
}

void FrameStore::stage(std::uint32_t frame_index, std::uint32_t frames, std::uint64_t commit_number,
                       std::span<const std::uint8_t> pixels) {
  thread_owner_.check();
  set_frame_count(frames);
  copy_frame(frame_index, commit_number, pixels);
}

void FrameStore::copy_frame(std::uint32_t frame_index, std::uint64_t commit_number,
                            std::span<const std::uint8_t> pixels) {
  const std::size_t columns = config_.columns;
  const std::size_t row_bytes = std::size_t{kPixelsInWord} * words_in_row();
  std::uint8_t* to = staged_.mapped().data() + frame_bytes() * frame_index;
  const std::uint8_t* from = pixels.data();
  if (row_bytes == columns) {
    std::copy_n(from, frame_bytes(), to);
  } else {
    for (std::uint32_t row = 0; row < config_.rows; ++row, from += columns) {
      to = std::fill_n(std::copy_n(from, columns, to), row_bytes - columns, std::uint8_t{0});
    }
  }
  commit_numbers_[frame_index] = commit_number;
  const std::uint32_t neighbours = reach_frames();
  const std::uint32_t last = std::min(frame_index + neighbours, config_.frame_capacity - 1);
  for (std::uint32_t each = frame_index - std::min(frame_index, neighbours); each <= last; ++each)
    prepared_[each] = false;
}

std::uint64_t FrameStore::frames_at_a_time(const Scene::Speckle& options) const {
  const Gpu& gpu = *device_.gpu;
  // Larger buffers would save nothing: a dispatch over these frames keeps every GPU busy; a processor needs
  // less.
  const std::uint64_t most_bytes = gpu.candidate().kind == kProcessorKind ? 4 << 20 : 64 << 20;
  const std::uint64_t coefficient_bytes = frame_bytes() * sizeof(std::uint32_t);  // per frame
  const std::uint64_t neighbours = 2 * (static_cast<std::uint64_t>(options.across) / 2);
  const auto fitting = [&](std::uint64_t bytes) {
    const std::uint64_t frames = bytes / coefficient_bytes;
    return frames > neighbours ? std::min<std::uint64_t>(frames - neighbours, config_.frame_capacity) : 0;
  };
  const std::uint64_t limit = gpu.limits().maxStorageBufferRange;
  // Very large frames are filtered one at a time.
  return std::max(fitting(std::min(limit, most_bytes)), std::min<std::uint64_t>(fitting(limit), 1));
}

Result<void> FrameStore::create_filter_memory(const Scene::Speckle& options) {
  const Gpu& gpu = *device_.gpu;
  if (is_prepared_here()) return {};
  if (options.filter != SpeckleFilter::kNone && filtered_.bytes() == 0) {
    auto made = GpuBuffer::create(gpu, "filtered frames", staged_.bytes(),
                                  kWrittenTexels | VK_BUFFER_USAGE_TRANSFER_SRC_BIT, BufferPlace::kDevice,
                                  VK_FORMAT_R32_UINT);
    if (!made) return made.error();
    filtered_ = std::move(*made);
    bindings_changed_ = true;
  }
  if (options.filter != SpeckleFilter::kGuided) return {};
  const std::uint64_t at_a_time = frames_at_a_time(options);
  if (at_a_time == 0) return Error{ErrorCode::kUnsupported, "a frame is too large for the guided filter"};
  const std::uint64_t frames = at_a_time + 2 * (static_cast<std::uint64_t>(options.across) / 2);
  const std::uint64_t bytes = frames * frame_bytes() * sizeof(std::uint32_t);
  if (coefficients_.bytes() < bytes) {
    auto made = GpuBuffer::create(gpu, "guided filter coefficients", bytes,
                                  VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, BufferPlace::kDevice);
    if (!made) return made.error();
    coefficients_ = std::move(*made);
    bindings_changed_ = true;
  }
  return {};
}

FrameStore::Bindings FrameStore::bindings() const {
  // Memory of a filter on the GPU exists once one was requested; until then no shader uses these bindings.
  const auto existing = [](const GpuBuffer& buffer) { return buffer.bytes() > 0 ? &buffer : nullptr; };
  return {{{FANLIGHT_BINDING_FRAMES, existing(staged_)},
           {FANLIGHT_BINDING_FILTERED_FRAMES, existing(filtered_)},
           {FANLIGHT_BINDING_COEFFICIENTS, existing(coefficients_)},
           {FANLIGHT_BINDING_PREPARED_FRAMES, existing(filters() ? filtered_ : staged_)},
           {FANLIGHT_BINDING_PACKED, existing(packed_)},
           {FANLIGHT_BINDING_BLOCK_MIN_MAX, existing(blocks_)},
           {FANLIGHT_BINDING_NEIGHBOUR_MIN_MAX, existing(bounds_)},
           {FANLIGHT_BINDING_BLOCK_MIN_MAX_TEXELS, existing(blocks_)},
           {FANLIGHT_BINDING_NEIGHBOUR_MIN_MAX_TEXELS, existing(bounds_)}}};
}

Result<void> FrameStore::find_pipelines() {
  pipelines_ = {};
  if (is_prepared_here()) return {};
  const SpeckleKeys speckle(wanted_, config_.zero_is_unscanned);
  for (std::size_t half = 0; half < speckle.keys().size(); ++half) {
    auto pipeline = device_.pipelines->get(speckle.keys()[half]);
    if (!pipeline) return pipeline.error();
    pipelines_[half] = *pipeline;
  }
  return {};
}

Result<void> FrameStore::begin(const Scene::Speckle& options) {
  thread_owner_.check();
  if (left_out_ && options == refused_) {
    bindings_changed_ = false;  // requested again with every frame; there would still be no memory
    piece_frames_ = piece_frames();
    return {};
  }
  const Scene::Speckle before = std::exchange(wanted_, options);
  bindings_changed_ = (before.filter == SpeckleFilter::kNone) != (options.filter == SpeckleFilter::kNone);
  left_out_ = !create_filter_memory(options);
  if (left_out_) {
    refused_ = options;
    wanted_.filter = SpeckleFilter::kNone;
    bindings_changed_ = true;
  }
  if (wanted_ != before) prepared_.assign(prepared_.size(), false);
  piece_frames_ = piece_frames();
  return find_pipelines();
}

std::optional<FrameStore::Piece> FrameStore::next_piece() const {
  Piece piece;
  while (piece.first < frames_ && prepared_[piece.first]) ++piece.first;
  if (piece.first == frames_) return {};
  piece.end = piece.first;
  while (piece.end < std::min(piece.first + piece_frames_, frames_) && !prepared_[piece.end]) ++piece.end;
  return piece;
}

/// Cost of a pixel of pass 0, in samples of pass 1.
double FrameStore::samples_of_pixel() const {
  const double window = double{1} * wanted_.size * wanted_.size;
  const bool here = is_prepared_here();
  switch (wanted_.filter) {
    case SpeckleFilter::kMedian:
      return wanted_.across * window / (here ? 30 : 3);
    case SpeckleFilter::kGuided:
      return wanted_.across * (here ? 0.4 : 3.5);
    default:
      return wanted_.across * (here ? 0.1 : 1.5);
  }
}

std::uint32_t FrameStore::piece_frames() const {
  const bool at_a_time = wanted_.filter == SpeckleFilter::kGuided && !is_prepared_here();
  double frames =
      static_cast<double>(config_.piece_samples) / (samples_of_pixel() * static_cast<double>(frame_bytes()));
  // Each thread takes whole frames. The samples above are those of two.
  if (is_prepared_here())
    frames = std::max(std::ceil(frames / 2), 1.0) * static_cast<double>(config_.workers->threads());
  const std::uint64_t most = at_a_time ? frames_at_a_time(wanted_) : std::max(frames_, 1U);
  return static_cast<std::uint32_t>(std::clamp(frames, 1.0, static_cast<double>(most)));
}

void FrameStore::prepare_piece() {
  thread_owner_.check();
  const Piece piece = *next_piece();
  const StagedFrames staged{.pixels = staged_.mapped().data(),
                            .columns = config_.columns,
                            .rows = config_.rows,
                            .row_bytes = kPixelsInWord * words_in_row(),
                            .frames = frames_,
                            .zero_is_unscanned = config_.zero_is_unscanned};
  auto* const packed = &packed_.mapped_as<std::uint32_t>();
  auto* const bounds = &bounds_.mapped_as<std::uint32_t>();
  config_.workers->run(piece.end - piece.first, [&](std::size_t thread, std::size_t index) {
    const auto frame = static_cast<std::uint32_t>(piece.first + index);
    preparers_[thread].prepare(
        staged, wanted_, frame,
        {.packed = packed + packed_words() * frame, .bounds = bounds + bounds_words() * frame});
  });
  std::fill(prepared_.begin() + piece.first, prepared_.begin() + piece.end, true);
}

void FrameStore::record_piece(VkCommandBuffer commands) {
  thread_owner_.check();
  const Piece piece = *next_piece();
  if (filters()) record_filter(commands, piece);
  record_copies(commands, piece);
  std::fill(prepared_.begin() + piece.first, prepared_.begin() + piece.end, true);
}

void FrameStore::record_filter(VkCommandBuffer commands, Piece piece) {
  const auto [first, end] = piece;
  const bool guided = wanted_.filter == SpeckleFilter::kGuided;
  const std::uint32_t down =
      wanted_.filter == SpeckleFilter::kMedian ? config_.rows : groups(config_.rows, kRowsInGroup);
  const auto neighbours = static_cast<std::uint32_t>(wanted_.across / 2);
  shaders::PrepareConstants constants{.columns = config_.columns,
                                      .rows = config_.rows,
                                      .frames = frames_,
                                      .first_kept = first - std::min(first, neighbours),
                                      .radius_across = wanted_.across / 2,
                                      .noise = static_cast<float>(wanted_.noise),
                                      .levels = static_cast<float>(wanted_.levels)};
  static_assert(sizeof constants <= Pipelines::kPushBytes);
  const auto filter = [&](VkPipeline pipeline, std::uint32_t from, std::uint32_t to) {
    constants.first_frame = from;
    vkCmdPushConstants(commands, device_.pipelines->layout(), VK_SHADER_STAGE_COMPUTE_BIT, 0,
                       sizeof constants, &constants);
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
    vkCmdDispatch(commands, groups(words_in_row(), kWordsInGroup), down, to - from);
    barrier(commands, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
            VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_COPY_BIT,
            VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_SAMPLED_READ_BIT |
                VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT | VK_ACCESS_2_TRANSFER_READ_BIT);
  };
  if (guided) filter(pipelines_[0], constants.first_kept, std::min(end + neighbours, frames_));
  filter(pipelines_[guided ? 1 : 0], first, end);
}

void FrameStore::record_copies(VkCommandBuffer commands, Piece piece) {
  const std::uint32_t frames = piece.end - piece.first;
  const shaders::PrepareConstants constants{.columns = config_.columns,
                                            .rows = config_.rows,
                                            .frames = frames_,
                                            .first_frame = piece.first,
                                            .first_kept = 0,
                                            .radius_across = 0,
                                            .noise = 0,
                                            .levels = 0};
  vkCmdPushConstants(commands, device_.pipelines->layout(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof constants,
                     &constants);
  const auto run = [&](Shader shader, std::uint32_t across, std::uint32_t down) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, device_.pipelines->fixed(shader));
    vkCmdDispatch(commands, groups(across, kWordsInGroup), down, frames);
  };
  const std::uint32_t blocks_across = blocks_along(config_.columns);
  const std::uint32_t blocks_down = blocks_along(config_.rows);
  run(Shader::kBlockMinMax, blocks_across, blocks_down);
  copy_to_image(commands, filters() ? filtered_ : staged_, texture_,
                {.row_texels = kPixelsInWord * words_in_row(),
                 .first_slice = piece.first,
                 .slices = frames,
                 .keeps_others = std::exchange(texture_written_, true)});
  pass_barrier(commands);
  run(Shader::kNeighbourMinMax, blocks_across, blocks_down);
  pass_barrier(commands);
}

}  // namespace fanlight
