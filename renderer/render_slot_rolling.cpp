// The part of a slot's life in which frames replace those of the volume that it has cast: Refresh::kFrame.
#include <algorithm>
#include <utility>

#include "renderer/render_slot.hpp"

namespace fanlight {

void RenderSlot::change(std::uint32_t place) {
  const VolumeView::Places here{place, place};
  const VolumeView::Places known = changed_.value_or(here);
  changed_ = VolumeView::Places{std::min(known.first, place), std::max(known.last, place)};
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
  ++frames_turn_;
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
  if (auto begun = begin_frames(gpu, passes, scene.speckle); !begun) return begun;
  frames_gone_ = false;
  return view_.recast(gpu, passes, scene, seen(), *std::exchange(changed_, {}));
}

}  // namespace fanlight
