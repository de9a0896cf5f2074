// SPDX-License-Identifier: Apache-2.0
#include "server/bench/volumes.hpp"

#include <algorithm>
#include <filesystem>
#include <string>
#include <utility>

#include "acquisition/offline_volumes.hpp"

namespace fanlight {

Result<BenchVolumes> BenchVolumes::create(const BenchRow& row, std::uint32_t count) {
  Doorbell bell;
  ProbeLink probe(bell, bell);
  auto source = open_source(
      std::string(row.input),
      {.geometry_path = std::filesystem::path(row.geometry_path), .pace = SourcePace::kAsFastAsTaken}, probe);
  if (!source) return source.error();
  const SourceDescription description = (*source)->description();
  OfflineVolumes picker(**source);
  std::vector<Kept> kept;
  while (kept.size() < count) {
    const auto volume = picker.next();
    if (!volume) return volume.error();
    if (!*volume) break;
    const VolumeStamp& stamp = (*volume)->stamp();
    const std::uint32_t capacity = std::max(stamp.frames, description.usual_frames);
    Kept one{.stamps = {}, .volume = Volume((*volume)->geometry(), capacity)};
    for (std::uint32_t index = 0; index < stamp.frames; ++index) {
      one.stamps.push_back({.sequence = stamp.first_frame_sequence + index,
                            .volume_index = stamp.source_volume_index,
                            .frame_index = index,
                            .frames_in_sweep = stamp.frames,
                            .direction = stamp.direction,
                            .angle_rad = (*volume)->angles_rad()[index],
                            .capture_time_ns = stamp.first_capture_time_ns});
      std::ranges::copy((*volume)->frame_pixels(index), one.volume.next_frame_pixels().begin());
      one.volume.add_frame(one.stamps.back());
    }
    kept.push_back(std::move(one));
  }
  if (kept.empty()) {
    return Error{ErrorCode::kNotFound, "the source has no volume that can be rendered, expected one"};
  }
  // The renderer's two slots take turns: with three volumes no slot gets the same one twice in a row.
  constexpr std::size_t kFewest = 3;
  while (kept.size() < kFewest) kept.push_back(brighter(kept.back()));
  return BenchVolumes(description, std::move(kept));
}

BenchVolumes::Kept BenchVolumes::brighter(const Kept& from) {
  Kept copy{.stamps = from.stamps, .volume = Volume(from.volume.geometry(), from.volume.frame_capacity())};
  for (std::uint32_t index = 0; index < copy.stamps.size(); ++index) {
    std::ranges::transform(
        from.volume.frame_pixels(index), copy.volume.next_frame_pixels().begin(),
        [](std::uint8_t grey) { return static_cast<std::uint8_t>(std::min(grey + 1, 255)); });
    copy.volume.add_frame(copy.stamps[index]);
  }
  return copy;
}

std::uint32_t BenchVolumes::frame_capacity() const {
  std::uint32_t most = 0;
  for (const Kept& kept : kept_) most = std::max(most, kept.volume.frame_capacity());
  return most;
}

std::size_t BenchVolumes::held_bytes() const {
  std::size_t bytes = 0;
  for (const Kept& one : kept_) bytes += one.stamps.size() * one.volume.geometry().frame_bytes();
  return bytes;
}

const Volume& BenchVolumes::next() {
  Kept& kept = kept_[shown_++ % kept_.size()];
  kept.volume.clear();
  for (FrameStamp& stamp : kept.stamps) {
    stamp.commit_number = ++commit_numbers_;
    kept.volume.add_frame(stamp);
  }
  kept.volume.sort_by_angle();
  kept.volume.stamp().volume_id = shown_;
  return kept.volume;
}

QueuedFrame BenchVolumes::frame(std::uint32_t index) const {
  const Kept& kept = kept_[(shown_ - 1) % kept_.size()];
  return {.stamp = kept.stamps[index],
          .geometry = kept.volume.geometry(),
          .pixels = kept.volume.frame_pixels(index)};
}

}  // namespace fanlight
