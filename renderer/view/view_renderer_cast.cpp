// SPDX-License-Identifier: Apache-2.0
// ViewRenderer: the commands of passes 0 and 1.
#include <algorithm>
#include <array>
#include <utility>

#include "renderer/view/view_renderer.hpp"
#include "renderer/vulkan/command_recording.hpp"

namespace fanlight {

namespace {

// Tiles that a group of empty_space.comp and dirty_tiles.comp handles.
constexpr std::uint32_t kTilesInGroup = 8;

}  // namespace

Result<void> ViewRenderer::prepare_ahead(const VolumeBindings& volume) {
  if (auto begun = begin_commands(cast_commands_); !begun) return begun;
  descriptors_.bind(cast_commands_, *device_.pipelines, DescriptorSets::Order::kLitToDiffused);
  volume.frames.record_piece(cast_commands_, *device_.pipelines);
  return timeline_.submit(device_.gpu->cast_queue(), cast_commands_, other_work_);
}

Result<void> ViewRenderer::submit_frames(const VolumeBindings& volume) {
  const VkCommandBuffer commands = cast_commands_;
  if (auto begun = begin_commands(commands); !begun) return begun;
  descriptors_.bind(commands, *device_.pipelines, DescriptorSets::Order::kLitToDiffused);
  begin_piece(commands, Stage::kPrepare);
  if (!std::exchange(preparing_, true)) timestamps_.stamp(commands, GpuTimestamps::kPrepareBegin);
  volume.frames.record_piece(commands, *device_.pipelines);
  if (volume.frames.done()) timestamps_.stamp(commands, GpuTimestamps::kPrepareEnd);
  end_piece(commands);
  return timeline_.submit(device_.gpu->cast_queue(), commands, other_work_);
}

Result<void> ViewRenderer::cast_next_band(const VolumeBindings& volume) {
  if (!volume.frames.done()) return submit_frames(volume);
  const VkCommandBuffer commands = cast_commands_;
  if (auto begun = begin_commands(commands); !begun) return begun;
  descriptors_.bind(commands, *device_.pipelines, DescriptorSets::Order::kLitToDiffused);
  begin_piece(commands, Stage::kCast);
  if (next_tile_ == 0) record_before_rays(commands, volume.angles);
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, cast_pipelines_.cast);
  // Not a push constant: lavapipe keeps a copy of the shader for each value.
  memory_.cast_parameters.mapped_as<shaders::CastParameters>().first_tile = next_tile_;
  const std::uint32_t tiles = std::min(band_tiles_, cast_tiles_ - next_tile_);
  vkCmdDispatch(commands, tiles, 1, 1);
  next_tile_ += tiles;
  if (cast_submitted()) record_frame_steps(commands);
  if (cast_submitted()) record_slices(commands);
  if (cast_submitted()) record_maps_for_host(commands);
  if (cast_submitted()) timestamps_.stamp(commands, GpuTimestamps::kCastEnd);
  end_piece(commands);
  return timeline_.submit(device_.gpu->cast_queue(), commands, other_work_);
}

Result<void> ViewRenderer::recast(const VolumeBindings& volume, FrameRange frames_changed) {
  reset_times();

  const VkCommandBuffer commands = cast_commands_;
  if (auto begun = begin_commands(commands); !begun) return begun;
  descriptors_.bind(commands, *device_.pipelines, DescriptorSets::Order::kLitToDiffused);
  timestamps_.stamp(commands, GpuTimestamps::kPrepareBegin);
  while (!volume.frames.done()) volume.frames.record_piece(commands, *device_.pipelines);
  timestamps_.stamp(commands, GpuTimestamps::kPrepareEnd);
  timestamps_.stamp(commands, GpuTimestamps::kUploadBegin);
  record_tables(commands, volume.angles);
  timestamps_.stamp(commands, GpuTimestamps::kCastBegin);
  record_dirty_tiles(commands, volume.frames, frames_changed);
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, cast_pipelines_.cast_listed);
  vkCmdDispatchIndirect(commands, memory_.tile_list.get(), 0);
  record_frame_steps(commands);
  record_slices(commands);
  record_maps_for_host(commands);
  timestamps_.stamp(commands, GpuTimestamps::kCastEnd);
  confidence_known_ = false;
  cast_since_light_ = true;
  return timeline_.submit(device_.gpu->cast_queue(), commands, other_work_);
}

void ViewRenderer::record_tables(VkCommandBuffer commands, AngleBuffer& angles) {
  angles.record(commands);
  if (std::exchange(transfer_due_, false))
    copy_to_image(commands, memory_.staged_transfer, memory_.transfer, {});
}

void ViewRenderer::record_before_rays(VkCommandBuffer commands, AngleBuffer& angles) {
  timestamps_.stamp(commands, GpuTimestamps::kUploadBegin);
  record_tables(commands, angles);
  timestamps_.stamp(commands, GpuTimestamps::kCastBegin);
  if (notes_reach_) {
    vkCmdFillBuffer(commands, memory_.reached.get(), 0, VK_WHOLE_SIZE, 0);
    barrier(commands, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
            VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
            VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT);
  }
  record_empty_space(commands);
}

void ViewRenderer::record_empty_space(VkCommandBuffer commands) const {
  if (cast_pipelines_.empty_space == VK_NULL_HANDLE) return;
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, cast_pipelines_.empty_space);
  vkCmdDispatch(commands, groups(cast_tiles_, kTilesInGroup), 1, 1);
  pass_barrier(commands);
}

void ViewRenderer::record_frame_steps(VkCommandBuffer commands) const {
  if (cast_pipelines_.frame_steps == VK_NULL_HANDLE) return;
  // The rays have written both maps.
  barrier(commands, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
          VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
          VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT);
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, cast_pipelines_.frame_steps);
  vkCmdDispatch(commands, tiles_across(), tiles_down(), 1);
}

void ViewRenderer::record_slices(VkCommandBuffer commands) const {
  if (cast_pipelines_.slice == VK_NULL_HANDLE) return;
  barrier(commands, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
          VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT);
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, cast_pipelines_.slice);
  vkCmdDispatch(commands, tiles_across(), tiles_down(), 1);
}

/// Where passes 2 and 3 have a device of their own, the host copies what pass 1 has written.
void ViewRenderer::record_maps_for_host(VkCommandBuffer commands) const {
  if (config_.passes != ViewPasses::kCast) return;
  barrier(commands, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
          VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT);
}

void ViewRenderer::record_dirty_tiles(VkCommandBuffer commands, const FrameStore& frames,
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
  vkCmdPushConstants(commands, device_.pipelines->layout(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof range,
                     range.data());
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, cast_pipelines_.dirty_tiles);
  vkCmdDispatch(commands, groups(cast_tiles_, kTilesInGroup), 1, 1);
  barrier(commands, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
          VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT,
          VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT |
              VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT);
}

}  // namespace fanlight
