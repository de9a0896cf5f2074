// SPDX-License-Identifier: Apache-2.0
#include "renderer/passes/cast_pass.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <functional>
#include <iterator>
#include <numeric>
#include <utility>
#include <vector>

#include "proto/base/clock.hpp"
#include "renderer/parameters/cast_parameters.hpp"
#include "renderer/parameters/effective_scene.hpp"
#include "renderer/vulkan/command_recording.hpp"
#include "shaders/bindings.h"

namespace fanlight {

namespace {

// Tiles that a group of empty_space.comp and dirty_tiles.comp handles.
constexpr std::uint32_t kTilesInGroup = 8;

// Tiles that a thread of the processor casts at a time: a picture has some thousand.
constexpr std::uint32_t kTilesInPiece = 8;
// And searches between two looks at what else is due: some milliseconds.
constexpr std::uint32_t kTilesInSearch = 4096;
// A list of tiles begins with the sizes of its dispatch, of which the first is its length (dirty_tiles.comp).
constexpr std::size_t kListHead = 3;

// The specialisation constants of cast.comp.
ray_caster::Method method_of(const PipelineKey& cast) {
  const auto& constants = cast.constants;
  return {.window = constants[0],
          .kept = constants[1],
          .frames = constants[2],
          .place = constants[3],
          .across = constants[4],
          .skips = constants[5] != 0,
          .sign = constants[6],
          .counts = constants[7] == FANLIGHT_CAST_ALL_COUNTED};
}

std::uint32_t tiles_along(std::uint32_t pixels) {
  return groups(pixels, kTileSide);
}

}  // namespace

Result<CastPass> CastPass::create(const PassDevice& device, const Config& config) {
  CastPass made(config);
  const bool here = config.ray_workers != nullptr;
  const auto place = [](bool for_host) { return for_host ? BufferPlace::kFromGpu : BufferPlace::kDevice; };
  auto memory =
      CastMemory::create(*device.gpu, config.largest, place(here || config.maps_for_host), place(here));
  if (!memory) return memory.error();
  made.memory_ = std::move(*memory);
  auto recorder = PassRecorder::create(device, {.name = "cast pass", .pauses = config.pauses});
  if (!recorder) return recorder.error();
  made.recorder_ = std::move(*recorder);
  made.memory_.write_to(made.recorder_.descriptors());
  return made;
}

void CastPass::bind(const VolumeBindings& volume) {
  const DescriptorSets& descriptors = recorder_.descriptors();
  descriptors.write(FANLIGHT_BINDING_VOLUME, volume.frames.texture());
  const GpuBuffer none;
  for (const auto& [binding, buffer] : volume.frames.bindings())
    descriptors.write(binding, buffer != nullptr ? *buffer : none);
  descriptors.write(FANLIGHT_BINDING_ANGLE_TABLE, volume.angles.entries());
  const bool own = volume.written.semaphore == recorder_.timeline().newest().semaphore;
  volume_written_ = own ? TimelinePoint{} : volume.written;
}

Result<void> CastPass::find_pipelines(const Scene& scene, const FanGeometry& geometry) {
  CastKeys keys = cast_keys(scene, geometry, config_.skipping, config_.counting);
  method_ = method_of(keys.cast);
  finds_empty_space_ = keys.empty_space.has_value();
  notes_reach_ = keys.dirty_tiles.has_value();
  std::optional<PipelineKey> cast = keys.cast;
  if (casts_here()) cast = keys.cast_listed = keys.empty_space = keys.dirty_tiles = std::nullopt;
  const std::pair<VkPipeline*, std::optional<PipelineKey>> wanted[] = {
      {&pipelines_.cast, cast},
      {&pipelines_.empty_space, keys.empty_space},
      {&pipelines_.cast_listed, keys.cast_listed},
      {&pipelines_.dirty_tiles, keys.dirty_tiles},
      {&pipelines_.frame_steps, keys.frame_steps},
      {&pipelines_.slice, keys.slice}};
  for (const auto& [pipeline, key] : wanted) {
    auto built = recorder_.pipelines().get(key);
    if (!built) return built.error();
    *pipeline = *built;
  }
  return {};
}

/// Cuts the picture into tiles and the tiles into bands.
void CastPass::set_tiles(const Scene& scene, const shaders::CastParameters& parameters) {
  const std::uint64_t samples_across = std::max(FANLIGHT_ACROSS_POINTS * (scene.rays.window / 2), 1);
  const std::uint64_t tile_samples =
      std::uint64_t{kTileSide} * kTileSide * samples_across * std::max(parameters.steps, 1U);
  const std::uint32_t tile_side = kTileSide * parameters.pixel_stride;
  tiles_ = groups(size_.width, tile_side) * groups(size_.height, tile_side);
  const std::uint32_t most_groups = recorder_.gpu().limits().maxComputeWorkGroupCount[0];
  notes_reach_ = notes_reach_ && tiles_ <= most_groups;  // a list of dirty tiles is not cut into bands
  const std::uint64_t most_tiles = std::min(tiles_, most_groups);
  band_tiles_ = static_cast<std::uint32_t>(
      std::clamp<std::uint64_t>(config_.band_samples / tile_samples, 1, most_tiles));
}

Result<void> CastPass::begin(const Scene& wanted, const VolumeBindings& volume) {
  const Scene scene = effective_scene(wanted, volume.geometry, config_.size, volume.levels);
  if (auto found = find_pipelines(scene, volume.geometry); !found) return found;
  ++number_;
  weighted_ = false;
  size_ = size_of(scene, config_.size);

  // Memory that the GPU reads may be slow to read for the processor, so values that are needed again are
  // kept.
  const CutList& shapes = scene.cuts.shapes;
  if (cuts_.update(shapes, cut_grid(volume.geometry, volume.extent)) && !shapes.empty())
    cuts_.write_cells(memory_.cut_cells.mapped());
  shaders::CastParameters parameters =
      cast_parameters(scene, size_, volume.geometry, volume.table, volume.extent);
  set_cuts(parameters, shapes, cuts_.grid());
  memory_.parameters.mapped_as<shaders::CastParameters>() = parameters;
  memory_.near_tissue.mapped_as<shaders::NearTissueParameters>() =
      near_tissue_parameters(scene, parameters, volume.geometry, volume.extent, volume.near_tissue);
  farthest_mm_ = parameters.end;
  segments_in_ray_ = groups(parameters.steps, 1U << parameters.segment_shift);
  reset_times();
  set_tiles(scene, parameters);
  next_tile_ = 0;
  end_tile_ = tiles_;
  next_searched_ = 0;
  replaced_.reset();
  if (transferred_ != scene.transfer || transferred_step_mm_ != parameters.step) {
    transfer_due_ = true;  // also after a cast that is given up before its first band
    memory_.staged_transfer.mapped_as<TransferTable>() = transfer_table(scene.transfer, parameters.step);
    transferred_ = scene.transfer;
    transferred_step_mm_ = parameters.step;
  }
  return {};
}

void CastPass::reset_times() {
  recorder_.reset_times();
  preparing_ = false;
  prepared_here_ = {};
  cast_here_ = {};
}

Result<void> CastPass::submit() {
  return recorder_.submit(recorder_.gpu().cast_queue(), volume_written_);
}

/// Submits the last commands that write the maps.
Result<void> CastPass::submit_maps(VkQueue queue) {
  auto submitted = recorder_.submit(queue, volume_written_);
  maps_written_ = recorder_.timeline().newest();
  return submitted;
}

/// Runs a piece of pass 0 on the processor.
void CastPass::prepare_here(FrameStore& frames) {
  // Processors gather, and their clock is this one.
  const std::int64_t began_ns = now_ns();
  if (!std::exchange(preparing_, true)) prepared_here_.begin_ns = began_ns;
  frames.prepare_piece();
  prepared_here_.end_ns = now_ns();
  recorder_.add_ms(Stage::kPrepare, StageSpan{.begin_ns = began_ns, .end_ns = prepared_here_.end_ns}.ms());
}

std::array<StageSpan, kStages> CastPass::stage_spans() const {
  auto spans = recorder_.stage_spans();
  if (prepared_here_.end_ns > 0) spans[static_cast<std::size_t>(Stage::kPrepare)] = prepared_here_;
  if (cast_here_.end_ns > 0) {
    StageSpan& cast = spans[static_cast<std::size_t>(Stage::kCast)];  // what came after the rays
    cast = {.begin_ns = cast_here_.begin_ns, .end_ns = std::max(cast_here_.end_ns, cast.end_ns)};
  }
  return spans;
}

Result<void> CastPass::prepare_ahead(const VolumeBindings& volume) {
  if (volume.frames.is_prepared_here()) {
    volume.frames.prepare_piece();
    return {};
  }
  const auto commands = recorder_.begin();
  if (!commands) return commands.error();
  volume.frames.record_piece(*commands);
  return submit();
}

Result<void> CastPass::submit_frames(const VolumeBindings& volume) {
  const auto commands = recorder_.begin();
  if (!commands) return commands.error();
  recorder_.begin_piece(Stage::kPrepare);
  if (!std::exchange(preparing_, true)) recorder_.stamp(GpuTimestamps::kPrepareBegin);
  volume.frames.record_piece(*commands);
  if (volume.frames.done()) recorder_.stamp(GpuTimestamps::kPrepareEnd);
  return submit();
}

Result<void> CastPass::submit_next(const VolumeBindings& volume) {
  if (!volume.frames.done()) {
    if (!volume.frames.is_prepared_here()) return submit_frames(volume);
    prepare_here(volume.frames);
    if (!volume.frames.done()) return {};
  }
  if (casts_here()) return cast_next_here(volume);
  const auto commands = recorder_.begin();
  if (!commands) return commands.error();
  recorder_.begin_piece(Stage::kCast);
  if (next_tile_ == 0) record_before_rays(*commands, volume.angles);
  vkCmdBindPipeline(*commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipelines_.cast);
  // Not a push constant: lavapipe keeps a copy of the shader for each value.
  memory_.parameters.mapped_as<shaders::CastParameters>().first_tile = next_tile_;
  const std::uint32_t tiles = std::min(band_tiles_, tiles_ - next_tile_);
  vkCmdDispatch(*commands, tiles, 1, 1);
  next_tile_ += tiles;
  if (!submitted()) return submit();
  record_after_rays(*commands);
  return submit_maps(recorder_.gpu().cast_queue());
}

/// The next piece of pass 1 where the processor casts the rays.
Result<void> CastPass::cast_next_here(const VolumeBindings& volume) {
  if (next_searched_ < tiles_) {
    search_next_here(volume);
    return {};
  }
  const std::uint32_t tiles = std::min(band_tiles_, end_tile_ - next_tile_);
  cast_here(volume, next_tile_, tiles);
  next_tile_ += tiles;
  if (next_tile_ < end_tile_) return {};
  next_tile_ = tiles_;
  if (!has_work_after_rays()) {
    maps_written_ = recorder_.timeline().newest();  // which is done
    return {};
  }
  const auto commands = recorder_.begin();
  if (!commands) return commands.error();
  recorder_.begin_piece(Stage::kCast);
  recorder_.stamp(GpuTimestamps::kUploadBegin);
  record_tables(*commands, volume.angles);
  recorder_.stamp(GpuTimestamps::kCastBegin);
  record_after_rays(*commands);
  return submit_maps(recorder_.gpu().cast_queue());
}

/// Runs `task(first, end)` for pieces of some tiles on the processor. Counts as pass 1.
template <typename Task>
void CastPass::run_here(std::uint32_t tiles, const Task& task) {
  const std::int64_t began_ns = now_ns();
  if (cast_here_.begin_ns == 0) cast_here_.begin_ns = began_ns;
  config_.ray_workers->run(groups(tiles, kTilesInPiece), [&](std::size_t, std::size_t piece) {
    const std::uint32_t first = kTilesInPiece * static_cast<std::uint32_t>(piece);
    task(first, std::min(first + kTilesInPiece, tiles));
  });
  cast_here_.end_ns = now_ns();
  recorder_.add_ms(Stage::kCast, StageSpan{.begin_ns = began_ns, .end_ns = cast_here_.end_ns}.ms());
}

/// Finds in some more tiles the segments that the rays read, and whether replaced frames change them.
void CastPass::search_next_here(const VolumeBindings& volume) {
  const bool notes = notes_reach_ || config_.counting == Counting::kOn;
  const tile_search::Memory memory = {
      .rays = &memory_.parameters.mapped_as<shaders::CastParameters>(),
      .angle_table = volume.table.entries().data(),
      .neighbour_min_max = volume.frames.neighbour_min_max(),
      .segment_masks = finds_empty_space_ ? &memory_.segments.mapped_as<std::uint32_t>() : nullptr,
      .sample_ends = notes ? &memory_.reached.mapped_as<std::uint32_t>() : nullptr};
  const std::uint32_t from = next_searched_;
  const std::uint32_t tiles = std::min(kTilesInSearch, tiles_ - from);
  next_searched_ += tiles;
  if (!replaced_) {
    run_here(tiles, [&](std::uint32_t first, std::uint32_t end) {
      tile_search::find_segments(method_, memory, from + first, from + end);
    });
    return;
  }
  // A speckle filter across frames mixes a frame into its neighbours.
  const auto reach = static_cast<int>(volume.frames.reach_frames());
  const tile_search::ReplacedFrames frames = {.first = static_cast<int>(replaced_->first) - reach,
                                              .last = static_cast<int>(replaced_->last) + reach};
  std::uint32_t* const marks = &memory_.tile_list.mapped_as<std::uint32_t>() + kListHead;
  run_here(tiles, [&](std::uint32_t first, std::uint32_t end) {
    tile_search::find_changes(method_, memory, frames, from + first, from + end, marks);
  });
  if (next_searched_ == tiles_) list_dirty_tiles();
}

/// Puts the numbers of the marked tiles in the place of the marks.
void CastPass::list_dirty_tiles() {
  std::uint32_t* const list = &memory_.tile_list.mapped_as<std::uint32_t>() + kListHead;
  end_tile_ = 0;  // no tile is listed behind its own mark
  for (std::uint32_t tile = 0; tile < tiles_; ++tile) {
    if (list[tile] != 0) list[end_tile_++] = tile;
  }
}

ray_caster::Memory CastPass::ray_memory(const VolumeBindings& volume) const {
  const bool notes = notes_reach_ || config_.counting == Counting::kOn;
  return {.rays = &memory_.parameters.mapped_as<shaders::CastParameters>(),
          .near_tissue = &memory_.near_tissue.mapped_as<shaders::NearTissueParameters>(),
          .packed_columns = volume.frames.packed_columns(),
          .angle_table = volume.table.entries().data(),
          .transfer = &memory_.staged_transfer.mapped_as<float>(),
          .cut_cells = &memory_.cut_cells.mapped_as<std::uint32_t>(),
          .segment_masks = &memory_.segments.mapped_as<std::uint32_t>(),
          .depth = &memory_.maps.depth.mapped_as<float>(),
          .ray_depth = &memory_.ray_depth.mapped_as<float>(),
          .volume_colour = &memory_.maps.colour.mapped_as<std::uint32_t>(),
          .sample_ends = notes ? &memory_.reached.mapped_as<std::uint32_t>() : nullptr};
}

/// Casts the rays of some tiles, or of places in the list of tiles, on the processor.
void CastPass::cast_here(const VolumeBindings& volume, std::uint32_t first, std::uint32_t tiles) {
  const ray_caster::Memory memory = ray_memory(volume);
  const std::uint32_t* const list =
      replaced_ ? &memory_.tile_list.mapped_as<std::uint32_t>() + kListHead : nullptr;
  run_here(tiles, [&](std::uint32_t begin, std::uint32_t end) {
    ray_caster::cast_tiles(method_, memory, first + begin, first + end, list);
  });
}

Result<void> CastPass::recast(const VolumeBindings& volume, FrameRange frames_changed) {
  reset_times();
  while (volume.frames.is_prepared_here() && !volume.frames.done()) prepare_here(volume.frames);
  ++number_;
  weighted_ = false;
  if (casts_here()) {
    next_tile_ = next_searched_ = 0;
    replaced_ = frames_changed;
    return {};
  }
  const auto commands = recorder_.begin();
  if (!commands) return commands.error();
  recorder_.begin_piece(Stage::kCast);
  if (!volume.frames.done()) {
    recorder_.stamp(GpuTimestamps::kPrepareBegin);
    while (!volume.frames.done()) volume.frames.record_piece(*commands);
    recorder_.stamp(GpuTimestamps::kPrepareEnd);
  }
  recorder_.stamp(GpuTimestamps::kUploadBegin);
  record_tables(*commands, volume.angles);
  recorder_.stamp(GpuTimestamps::kCastBegin);
  record_dirty_tiles(*commands, volume.frames, frames_changed);
  vkCmdBindPipeline(*commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipelines_.cast_listed);
  vkCmdDispatchIndirect(*commands, memory_.tile_list.get(), 0);
  record_after_rays(*commands);
  return submit_maps(recorder_.gpu().cast_queue());
}

bool CastPass::weights_due(const Scene& wanted, const VolumeBindings& volume) const {
  const Scene scene = effective_scene(wanted, volume.geometry, config_.size, volume.levels);
  return scene.filter.weights == FilterWeights::kConfidence && !weighted_ && !volume.frames_gone &&
         volume.frames.done();
}

Result<void> CastPass::add_weights(const Scene& wanted, const VolumeBindings& volume) {
  const Scene scene = effective_scene(wanted, volume.geometry, config_.size, volume.levels);
  const auto pipeline = recorder_.pipelines().get(confidence_key(scene, volume.geometry));
  if (!pipeline) return pipeline.error();
  const auto commands = recorder_.begin();
  if (!commands) return commands.error();
  // They count as part of the filter.
  recorder_.begin_piece(Stage::kFilter);
  record_tables(*commands, volume.angles);
  recorder_.stamp(GpuTimestamps::kFilterBegin);
  vkCmdBindPipeline(*commands, VK_PIPELINE_BIND_POINT_COMPUTE, *pipeline);
  vkCmdDispatch(*commands, tiles_along(size_.width), tiles_along(size_.height), 1);
  record_maps_for_host(*commands);
  recorder_.stamp(GpuTimestamps::kLightBegin);
  // A light follows at once, and pass 1 of the other volume is not to come before it.
  if (auto submitted = submit_maps(recorder_.gpu().light_queue()); !submitted) return submitted;
  weighted_ = true;
  return {};
}

void CastPass::drop_held() {
  recorder_.drop_held();
  transfer_due_ = transferred_.has_value();  // the table may have been part of it
}

void CastPass::drop_held_weights() {
  if (!recorder_.timeline().holds()) return;
  drop_held();
  maps_written_ = recorder_.timeline().newest();
  weighted_ = false;
}

void CastPass::record_tables(VkCommandBuffer commands, AngleBuffer& angles) {
  angles.record(commands);
  if (std::exchange(transfer_due_, false))
    copy_to_image(commands, memory_.staged_transfer, memory_.transfer, {});
}

void CastPass::record_before_rays(VkCommandBuffer commands, AngleBuffer& angles) {
  recorder_.stamp(GpuTimestamps::kUploadBegin);
  record_tables(commands, angles);
  recorder_.stamp(GpuTimestamps::kCastBegin);
  if (notes_reach_ || config_.counting == Counting::kOn) {
    vkCmdFillBuffer(commands, memory_.reached.get(), 0, VK_WHOLE_SIZE, 0);
    barrier(commands, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
            VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
            VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT);
  }
  record_empty_space(commands);
}

bool CastPass::has_work_after_rays() const {
  return pipelines_.frame_steps != VK_NULL_HANDLE || pipelines_.slice != VK_NULL_HANDLE;
}

void CastPass::record_after_rays(VkCommandBuffer commands) const {
  record_frame_steps(commands);
  record_slices(commands);
  record_maps_for_host(commands);
  recorder_.stamp(GpuTimestamps::kCastEnd);
}

void CastPass::record_empty_space(VkCommandBuffer commands) const {
  if (pipelines_.empty_space == VK_NULL_HANDLE) return;
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipelines_.empty_space);
  vkCmdDispatch(commands, groups(tiles_, kTilesInGroup), 1, 1);
  pass_barrier(commands);
}

void CastPass::record_frame_steps(VkCommandBuffer commands) const {
  if (pipelines_.frame_steps == VK_NULL_HANDLE) return;
  // The rays have written both maps.
  barrier(commands, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
          VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
          VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT);
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipelines_.frame_steps);
  vkCmdDispatch(commands, tiles_along(size_.width), tiles_along(size_.height), 1);
}

void CastPass::record_slices(VkCommandBuffer commands) const {
  if (pipelines_.slice == VK_NULL_HANDLE) return;
  barrier(commands, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
          VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT);
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipelines_.slice);
  vkCmdDispatch(commands, tiles_along(size_.width), tiles_along(size_.height), 1);
}

void CastPass::record_maps_for_host(VkCommandBuffer commands) const {
  if (config_.maps_for_host) host_barrier(commands);
}

void CastPass::record_dirty_tiles(VkCommandBuffer commands, const FrameStore& frames,
                                  FrameRange frames_changed) const {
  constexpr std::array<std::uint32_t, 3> kNone = {0, 1, 1};
  const VkBufferCopy all{.size = memory_.segments.bytes()};
  vkCmdCopyBuffer(commands, memory_.segments.get(), memory_.old_segments.get(), 1, &all);
  vkCmdUpdateBuffer(commands, memory_.tile_list.get(), 0, sizeof kNone, kNone.data());
  barrier(commands, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
          VK_ACCESS_2_TRANSFER_WRITE_BIT | VK_ACCESS_2_TRANSFER_READ_BIT,
          VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
          VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT);
  record_empty_space(commands);
  // A speckle filter across frames mixes a frame into its neighbours.
  const auto reach = static_cast<std::int32_t>(frames.reach_frames());
  const std::array<std::int32_t, 2> range = {static_cast<std::int32_t>(frames_changed.first) - reach,
                                             static_cast<std::int32_t>(frames_changed.last) + reach};
  vkCmdPushConstants(commands, recorder_.pipelines().layout(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof range,
                     range.data());
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipelines_.dirty_tiles);
  vkCmdDispatch(commands, groups(tiles_, kTilesInGroup), 1, 1);
  barrier(commands, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
          VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT,
          VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT |
              VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT);
}

/// Memory that `record` has copied to. Blocks until it has.
Result<GpuBuffer> CastPass::copied(std::uint64_t bytes, const RecordCopies& record) {
  auto copy = GpuBuffer::create(recorder_.gpu(), "map copies", bytes, VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                                BufferPlace::kFromGpu);
  if (!copy) return copy.error();
  const auto commands = recorder_.begin();
  if (!commands) return commands.error();
  record(*commands, *copy);
  barrier(*commands, VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
          VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT);
  if (auto submitted = submit(); !submitted) return submitted.error();
  constexpr std::uint64_t kMostNs = 60'000'000'000;  // copies only
  if (auto waited = recorder_.timeline().wait(kMostNs); !waited) return waited.error();
  if (recorder_.outstanding() > 0) {
    const Error hung{ErrorCode::kLost, "the GPU did not copy its maps within a minute"};
    recorder_.gpu().note_fault(Gpu::Condition::kHung, hung);
    return hung;
  }
  return copy;
}

Result<std::uint64_t> CastPass::read_sample_count() {
  const std::uint64_t bytes = std::uint64_t{tiles_} * sizeof(std::uint32_t);
  const auto copy = copied(bytes, [&](VkCommandBuffer commands, const GpuBuffer& to) {
    const VkBufferCopy region{.size = bytes};
    vkCmdCopyBuffer(commands, memory_.reached.get(), to.get(), 1, &region);
  });
  if (!copy) return copy.error();
  const auto* const counts = &copy->mapped_as<std::uint32_t>();
  return std::accumulate(counts, counts + tiles_, std::uint64_t{0});
}

Result<DepthMaps> CastPass::read_maps() {
  const GpuBuffer* const maps[] = {&memory_.maps.depth, &memory_.maps.confidence};
  const std::uint64_t map_bytes = size_.pixels() * sizeof(float);
  const std::uint64_t maps_bytes = std::size(maps) * map_bytes;
  const auto copy =
      copied(maps_bytes + memory_.segments.bytes(), [&](VkCommandBuffer commands, const GpuBuffer& to) {
        for (std::size_t map = 0; map < std::size(maps); ++map) {
          const VkBufferCopy region{.dstOffset = map * map_bytes, .size = map_bytes};
          vkCmdCopyBuffer(commands, maps[map]->get(), to.get(), 1, &region);
        }
        const VkBufferCopy region{.dstOffset = maps_bytes, .size = memory_.segments.bytes()};
        vkCmdCopyBuffer(commands, memory_.segments.get(), to.get(), 1, &region);
      });
  if (!copy) return copy.error();
  const auto* values = reinterpret_cast<const float*>(copy->mapped().data());
  const std::size_t pixels = map_bytes / sizeof(float);
  const auto map = [&](std::size_t index) {
    return std::vector<float>(values + index * pixels, values + (index + 1) * pixels);
  };
  const auto* words = reinterpret_cast<const std::uint32_t*>(copy->mapped().data() + maps_bytes);
  const std::uint64_t sampled = std::transform_reduce(
      words, words + tiles_ * sizeof(glm::uvec4) / sizeof *words, std::uint64_t{0}, std::plus(),
      [](std::uint32_t word) { return static_cast<std::uint64_t>(std::popcount(word)); });
  const auto segments = static_cast<double>(std::uint64_t{tiles_} * segments_in_ray_);
  return DepthMaps{
      .cast_mm = map(0),
      .confidence = weighted_ ? map(1) : std::vector<float>(),
      .smooth_mm = {},
      .sampled_share = !finds_empty_space_ ? 1 : static_cast<double>(sampled) / std::max(segments, 1.0)};
}

}  // namespace fanlight
