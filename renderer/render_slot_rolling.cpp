// The part of a slot's life in which frames replace those of the volume that it has cast: Refresh::kFrame.
#include <algorithm>
#include <array>
#include <utility>

#include "renderer/command_recording.hpp"
#include "renderer/render_slot.hpp"
#include "shaders/bindings.h"

namespace fanlight {

namespace {

constexpr std::uint32_t kLines = 8;  // tiles in a group of the passes that take one an invocation

}  // namespace

void RenderSlot::change(std::uint32_t place) {
  const Places here{place, place};
  const Places known = changed_.value_or(here);
  changed_ = Places{std::min(known.first, place), std::max(known.last, place)};
}

bool RenderSlot::replace(const FedFrame& frame, std::uint32_t place, double angle_rad) {
  const bool fits =
      frames_.suits(frame.geometry) && frame.geometry == geometry_ && place < angles_rad_.size();
  // Past a neighbour the order of the frames would be another.
  const bool in_order = fits && (place == 0 || angles_rad_[place - 1] < angle_rad) &&
                        (place + 1 == angles_rad_.size() || angle_rad < angles_rad_[place + 1]);
  if (!in_order) return false;
  frames_.stage(place, static_cast<std::uint32_t>(angles_rad_.size()), frame.stamp.arrival, frame.pixels);
  change(place);
  if (angles_rad_[place] != angle_rad) {
    // At the border of the fan the angle decides how far every ray goes.
    changed_beyond_ |= place == 0 || place + 1 == angles_rad_.size();
    angles_rad_[place] = angle_rad;
    place_angles();
  }
  volume_.last_frame_sequence = frame.stamp.sequence;
  volume_.last_capture_time_ns = frame.stamp.capture_time_ns;
  return true;
}

Result<void> RenderSlot::complete(const Gpu& gpu, const Volume& volume) {
  const auto frames = static_cast<std::uint32_t>(angles_rad_.size());
  const bool alike =
      frames_.suits(volume) && volume.geometry() == geometry_ && volume.stamp().frames == frames;
  const auto order = volume.by_angle();
  bool same_angles = alike;
  for (std::uint32_t place = 0; alike && place < frames; ++place) {
    if (!frames_.holds(place, volume.arrivals()[order[place]])) change(place);
    same_angles &= angles_rad_[place] == volume.angles_rad()[order[place]];
  }
  changed_beyond_ |= !same_angles;
  return load(gpu, volume);
}

Result<void> RenderSlot::recast(const Gpu& gpu, Passes& passes, const Scene& scene) {
  if (auto begun = frames_.begin(gpu, passes, scene.speckle); !begun) return begun;
  if (frames_.bindings_changed()) write_frame_descriptors(gpu);
  auto listed = passes.cast(scene, geometry_.kind, config_.skipping, FANLIGHT_CAST_LISTED);
  if (!listed) return listed.error();
  auto changed = passes.changed(scene);
  if (!changed) return changed.error();
  clock_.reset(gpu);

  const VkCommandBuffer commands = cast_commands_;
  if (auto begun = begin_commands(commands); !begun) return begun;
  descriptors_.bind(commands, passes, DescriptorSets::Order::kLitToDiffused);
  clock_.stamp(commands, StageClock::kPrepareBegin);
  while (!frames_.done()) frames_.record_piece(commands, passes);
  clock_.stamp(commands, StageClock::kPrepareEnd);
  clock_.stamp(commands, StageClock::kUploadBegin);
  record_tables(commands);
  clock_.stamp(commands, StageClock::kCastBegin);
  record_changed_tiles(commands, passes, *changed);
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, *listed);
  vkCmdDispatchIndirect(commands, memory_.tile_list.get(), 0);
  record_slices(commands);
  clock_.stamp(commands, StageClock::kCastEnd);
  confidence_known_ = false;
  frames_gone_ = false;
  cast_since_light_ = true;
  changed_.reset();
  return submit(gpu.cast_queue(), commands);
}

void RenderSlot::record_changed_tiles(VkCommandBuffer commands, const Passes& passes,
                                      VkPipeline changed) const {
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
  const auto beside = static_cast<std::int32_t>(frames_.reach_across());
  const std::array<std::int32_t, 2> frames = {static_cast<std::int32_t>(changed_->first) - beside,
                                              static_cast<std::int32_t>(changed_->last) + beside};
  vkCmdPushConstants(commands, passes.layout(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof frames, frames.data());
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, changed);
  vkCmdDispatch(commands, groups(cast_tiles_, kLines), 1, 1);
  barrier(commands, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
          VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT,
          VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT |
              VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT);
}

}  // namespace fanlight
