// SPDX-License-Identifier: Apache-2.0
#include "renderer/volume_in_flight.hpp"

#include <algorithm>
#include <utility>

namespace fanlight {

Result<VolumeInFlight> VolumeInFlight::create(const Gpu& gpu, const Pipelines& pipelines,
                                              const Config& config) {
  VolumeInFlight made(config);
  auto angles = AngleBuffer::create(gpu, made.table_.entries().size());
  if (!angles) return angles.error();
  made.angles_ = std::move(*angles);
  if (auto step = made.create_frames(gpu, config.geometry, config.usual_frames); !step) return step.error();
  auto view = ViewRenderer::create(
      gpu, pipelines,
      {.size = config.size, .band_samples = config.band_samples, .skipping = config.skipping});
  if (!view) return view.error();
  made.view_ = std::move(*view);
  made.view_.bind(gpu, made.bindings());
  return made;
}

Result<void> VolumeInFlight::create_frames(const Gpu& gpu, const FanGeometry& geometry,
                                           std::uint32_t frames) {
  auto made = FrameStore::create(gpu, {.columns = geometry.columns,
                                       .rows = geometry.rows,
                                       .frame_capacity = frames,
                                       .piece_samples = config_.band_samples,
                                       .sampling = config_.sampling});
  if (!made) return made.error();
  frames_ = std::move(*made);
  return {};
}

Result<void> VolumeInFlight::replace_frames(const Gpu& gpu, const Volume& volume) {
  frames_ = FrameStore();  // frees the memory first: two of the largest volumes may not fit
  // The sweeps of a motor vary in length. Spare room avoids an allocation for the next longer sweep.
  const std::uint32_t frames = volume.stamp().frames;
  const std::uint32_t with_spare = std::min(frames + frames / 8, config_.frame_capacity);
  auto made = create_frames(gpu, volume.geometry(), std::max(frames, with_spare));
  bind_view(gpu);
  return made;
}

void VolumeInFlight::bind_view(const Gpu& gpu) {
  ++bindings_version_;
  view_.bind(gpu, bindings());
}

Result<void> VolumeInFlight::prepare(const Gpu& gpu, Pipelines& pipelines, const Scene& scene) {
  geometry_ = config_.geometry;
  const Scene known = effective(scene, {});
  if (auto begun = frames_.begin(gpu, pipelines, known.speckle); !begun) return begun;
  bind_view(gpu);
  return view_.find_cast_pipelines(pipelines, known, geometry_.kind);
}

Result<void> VolumeInFlight::load(const Gpu& gpu, const Volume& volume, const EchoLevels& levels) {
  ++frames_version_;  // also where the old frames are freed and the new ones fail
  if (!frames_.suits(volume)) {
    if (auto made = replace_frames(gpu, volume); !made) return made;
  }
  frames_.load(volume);
  geometry_ = volume.geometry();
  levels_ = levels;
  angles_rad_.clear();
  for (const std::uint32_t index : volume.by_angle()) angles_rad_.push_back(volume.angles_rad()[index]);
  update_angles();
  volume_ = volume.stamp();
  return {};
}

void VolumeInFlight::update_angles() {
  if (table_.update(angles_rad_)) angles_.put(table_.entries());
  extent_ = {.first_angle_rad = angles_rad_.front(),
             .last_angle_rad = angles_rad_.back(),
             .frames = static_cast<std::uint32_t>(angles_rad_.size()),
             .frame_capacity = frames_.frame_capacity()};
}

void VolumeInFlight::stage(const FanGeometry& geometry, std::uint32_t frame_index, std::uint32_t frames,
                           std::uint64_t commit_number, std::span<const std::uint8_t> pixels) {
  if (!frames_.suits(geometry) || std::max(frame_index + 1, frames) > frames_.frame_capacity()) return;
  ++frames_version_;
  frames_.stage(frame_index, frames, commit_number, pixels);
  frames_gone_ = true;
}

Result<bool> VolumeInFlight::prepare_ahead(const Gpu& gpu, Pipelines& pipelines, const Scene& scene,
                                           const EchoLevels& levels) {
  if (!frames_gone_) return false;
  if (auto begun = begin_frames(gpu, pipelines, scene, levels); !begun) return begun.error();
  if (!frames_.prepares_single_frames() || frames_.done()) return false;
  if (auto submitted = view_.prepare_ahead(gpu, pipelines, bindings()); !submitted) return submitted.error();
  return true;
}

Result<void> VolumeInFlight::begin_cast(const Gpu& gpu, Pipelines& pipelines, const Scene& scene) {
  if (auto begun = begin_frames(gpu, pipelines, scene, levels_); !begun) return begun;
  frames_gone_ = false;
  changed_.reset();
  changed_beyond_ = false;
  return view_.begin_cast(gpu, pipelines, scene, bindings());
}

Result<void> VolumeInFlight::begin_frames(const Gpu& gpu, Pipelines& pipelines, const Scene& scene,
                                          const EchoLevels& levels) {
  const Scene::Speckle options = effective(scene, levels).speckle;
  if (auto begun = frames_.begin(gpu, pipelines, options); !begun) return begun;
  if (frames_.bindings_changed()) bind_view(gpu);
  if (!frames_.done()) ++frames_version_;
  return {};
}

}  // namespace fanlight
