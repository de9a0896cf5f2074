#include "server/bench_volumes.hpp"

#include <algorithm>
#include <utility>

#include "server/volume_picker.hpp"

namespace fanlight {

Result<BenchVolumes> BenchVolumes::create(const std::string& input, std::uint32_t count) {
  Doorbell bell;
  ProbeLink probe(bell, bell);
  auto source = open_source(input, {.as_fast_as_taken = true}, probe);
  if (!source) return source.error();
  const SourceDescription description = (*source)->description();
  VolumePicker picker(**source);
  std::vector<Kept> kept;
  std::uint32_t most_frames = 0;
  while (kept.size() < count) {
    const auto volume = picker.next();
    if (!volume) return volume.error();
    if (!*volume) break;
    const VolumeStamp& stamp = (*volume)->stamp();
    Kept one{.stamps = {}, .pixels = {}, .geometry = (*volume)->geometry()};
    for (std::uint32_t index = 0; index < stamp.frames; ++index) {
      one.stamps.push_back({.sequence = stamp.first_frame_sequence + index,
                            .volume_index = stamp.source_volume_index,
                            .frame_index = index,
                            .frames_in_sweep = stamp.frames,
                            .direction = stamp.direction,
                            .angle_rad = (*volume)->angles_rad()[index],
                            .capture_time_ns = stamp.first_capture_time_ns});
      const auto pixels = (*volume)->frame_pixels(index);
      one.pixels.insert(one.pixels.end(), pixels.begin(), pixels.end());
    }
    most_frames = std::max(most_frames, stamp.frames);
    kept.push_back(std::move(one));
  }
  if (kept.empty()) {
    return Error{ErrorCode::kNotFound, "the source has no volume that can be rendered, expected one"};
  }
  return BenchVolumes(description, std::move(kept), std::max(most_frames, description.usual_frames));
}

BenchVolumes::BenchVolumes(const SourceDescription& description, std::vector<Kept> kept,
                           std::uint32_t frame_capacity)
    : description_(description),
      kept_(std::move(kept)),
      next_(description.geometry, frame_capacity, description.largest_frame_bytes) {}

const Volume& BenchVolumes::next() {
  const Kept& kept = kept_[shown_ % kept_.size()];
  next_.clear();
  next_.set_geometry(kept.geometry);
  stamps_ = kept.stamps;
  const std::uint64_t frame_bytes = kept.geometry.frame_bytes();
  for (std::size_t index = 0; index < stamps_.size(); ++index) {
    stamps_[index].arrival = ++arrivals_;
    std::copy_n(kept.pixels.data() + index * frame_bytes, frame_bytes, next_.next_frame_pixels().data());
    next_.add_frame(stamps_[index]);
  }
  next_.sort_by_angle();
  next_.stamp().volume_id = ++shown_;
  return next_;
}

FedFrame BenchVolumes::frame(std::uint32_t index) const {
  return {.stamp = stamps_[index], .geometry = next_.geometry(), .pixels = next_.frame_pixels(index)};
}

}  // namespace fanlight
