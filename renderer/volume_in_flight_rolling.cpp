// SPDX-License-Identifier: Apache-2.0
// VolumeInFlight with Refresh::kFrame: frames replace those of the cast volume one by one.
#include <algorithm>
#include <utility>

#include "renderer/volume_in_flight.hpp"

namespace fanlight {

void VolumeInFlight::mark_changed(std::uint32_t frame_index) {
  const ViewRenderer::FrameRange single{frame_index, frame_index};
  const ViewRenderer::FrameRange known = changed_.value_or(single);
  changed_ = ViewRenderer::FrameRange{std::min(known.first, frame_index), std::max(known.last, frame_index)};
}

bool VolumeInFlight::replace(const QueuedFrame& frame, std::uint32_t frame_index, double angle_rad) {
  const bool fits =
      frames_.suits(frame.geometry) && frame.geometry == geometry_ && frame_index < angles_rad_.size();
  // An angle beyond a neighbour's would change the order of the frames.
  const bool in_order = fits && (frame_index == 0 || angles_rad_[frame_index - 1] < angle_rad) &&
                        (frame_index + 1 == angles_rad_.size() || angle_rad < angles_rad_[frame_index + 1]);
  if (!in_order) return false;
  frames_.stage(frame_index, static_cast<std::uint32_t>(angles_rad_.size()), frame.stamp.commit_number,
                frame.pixels);
  mark_changed(frame_index);
  ++frames_version_;
  if (angles_rad_[frame_index] != angle_rad) {
    // The first and the last angle bound the fan, and so the length of every ray.
    changed_beyond_ |= frame_index == 0 || frame_index + 1 == angles_rad_.size();
    angles_rad_[frame_index] = angle_rad;
    update_angles();
  }
  volume_.last_frame_sequence = frame.stamp.sequence;
  volume_.last_capture_time_ns = frame.stamp.capture_time_ns;
  return true;
}

Result<void> VolumeInFlight::complete(const Volume& volume, const EchoLevels& levels) {
  const auto frames = static_cast<std::uint32_t>(angles_rad_.size());
  const bool same_layout =
      frames_.suits(volume) && volume.geometry() == geometry_ && volume.stamp().frames == frames;
  const auto order = volume.by_angle();
  bool same_angles = same_layout;
  for (std::uint32_t frame_index = 0; same_layout && frame_index < frames; ++frame_index) {
    if (!frames_.holds(frame_index, volume.commit_numbers()[order[frame_index]])) mark_changed(frame_index);
    same_angles &= angles_rad_[frame_index] == volume.angles_rad()[order[frame_index]];
  }
  changed_beyond_ |= !same_angles || levels != levels_;
  return load(volume, levels);
}

Result<void> VolumeInFlight::recast(const Scene& scene) {
  if (auto begun = begin_frames(scene, levels_); !begun) return begun;
  frames_gone_ = false;
  note_cast();
  return view_.recast(bindings(), *std::exchange(changed_, {}));
}

}  // namespace fanlight
