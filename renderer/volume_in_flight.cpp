// SPDX-License-Identifier: Apache-2.0
#include "renderer/volume_in_flight.hpp"

#include <algorithm>
#include <utility>

namespace fanlight {

Result<VolumeInFlight> VolumeInFlight::create(const PassDevice& device, const Config& config,
                                              const PassDevice* light) {
  VolumeInFlight made(device, config);
  auto angles = AngleBuffer::create(*device.gpu, made.table_.entries().size());
  if (!angles) return angles.error();
  made.angles_ = std::move(*angles);
  if (auto step = made.create_frames(config.geometry, config.usual_frames); !step) return step.error();
  ViewRenderer::Config view_config{.size = config.size,
                                   .band_samples = config.band_samples,
                                   .skipping = config.skipping,
                                   .passes = light != nullptr ? ViewPasses::kCast : ViewPasses::kAll};
  auto view = ViewRenderer::create(device, view_config);
  if (!view) return view.error();
  made.view_ = std::move(*view);
  made.view_.bind(made.bindings());
  if (light == nullptr) return made;
  view_config.passes = ViewPasses::kLight;
  auto light_view = ViewRenderer::create(*light, view_config);
  if (!light_view) return light_view.error();
  made.light_.reset(new SeparateLight{.view = std::move(*light_view)});
  return made;
}

void VolumeInFlight::follow(const VolumeInFlight& other) {
  if (light_) {
    light_->view.follow(other.light_->view);
  } else {
    view_.follow(other.view_);
  }
}

Result<void> VolumeInFlight::light(const Scene& scene, History history) {
  if (!light_) return view_.light(scene, bindings(), history);
  SeparateLight& light = *light_;
  if (std::exchange(light.copy_due, false)) light.view.take_cast(view_);
  light.cast_in_picture = light.cast_new;
  auto begun = light.view.begin_light(scene, bindings(), history);
  return begun ? light.view.light_next_piece() : begun;
}

Result<void> VolumeInFlight::light_next_piece(const Scene* changed) {
  if (changed != nullptr) {
    if (auto done = light_->view.change_light(*changed, bindings()); !done) return done;
  }
  return light_->view.light_next_piece();
}

Result<bool> VolumeInFlight::add_confidence(const Scene& scene) {
  if (!light_) return false;
  auto added = view_.add_confidence(scene, bindings());
  light_->copy_due |= added && *added;
  return added;
}

void VolumeInFlight::note_cast() {
  if (light_) light_->copy_due = light_->cast_new = true;
}

std::uint64_t VolumeInFlight::outstanding() const {
  return view_.outstanding() + (light_ ? light_outstanding() : 0);
}

Result<void> VolumeInFlight::retry_held() {
  if (auto retried = view_.retry_held(); !retried) return retried;
  return light_ ? light_->view.retry_held() : Result<void>{};
}

void VolumeInFlight::drop_held() {
  view_.drop_held();
  if (light_) light_->view.drop_held();
}

std::array<StageSpan, kStages> VolumeInFlight::stage_spans() const {
  if (!light_) return view_.stage_spans();
  // Both devices count on the clock of the one processor.
  auto spans = light_->view.stage_spans();
  if (!light_->cast_in_picture) return spans;
  const auto cast = view_.stage_spans();
  for (const Stage stage : {Stage::kPrepare, Stage::kUpload, Stage::kCast}) {
    const auto index = static_cast<std::size_t>(stage);
    spans[index] = cast[index];
  }
  return spans;
}

std::array<double, kStages> VolumeInFlight::stage_ms() const {
  std::array<double, kStages> ms{};
  std::ranges::transform(stage_spans(), ms.begin(), &StageSpan::ms);
  return ms;
}

Result<DepthMaps> VolumeInFlight::read_depth() {
  auto maps = view_.read_depth();
  if (maps && light_) maps->smooth_mm.assign(depth_mm().begin(), depth_mm().end());
  return maps;
}

Result<void> VolumeInFlight::create_frames(const FanGeometry& geometry, std::uint32_t frames) {
  auto made = FrameStore::create(*device_.gpu, {.columns = geometry.columns,
                                                .rows = geometry.rows,
                                                .frame_capacity = frames,
                                                .piece_samples = config_.band_samples,
                                                .sampling = config_.sampling});
  if (!made) return made.error();
  frames_ = std::move(*made);
  return {};
}

Result<void> VolumeInFlight::replace_frames(const Volume& volume) {
  frames_ = FrameStore();  // frees the memory first: two of the largest volumes may not fit
  // The sweeps of a motor vary in length. Spare room avoids an allocation for the next longer sweep.
  const std::uint32_t frames = volume.stamp().frames;
  const std::uint32_t with_spare = std::min(frames + frames / 8, config_.frame_capacity);
  auto made = create_frames(volume.geometry(), std::max(frames, with_spare));
  bind_view();
  return made;
}

void VolumeInFlight::bind_view() {
  ++bindings_version_;
  view_.bind(bindings());
}

Result<void> VolumeInFlight::prepare(const Scene& scene) {
  geometry_ = config_.geometry;
  const Scene known = effective(scene, {});
  if (auto begun = frames_.begin(*device_.gpu, *device_.pipelines, known.speckle); !begun) return begun;
  bind_view();
  return view_.find_cast_pipelines(known, geometry_.kind);
}

Result<void> VolumeInFlight::load(const Volume& volume, const EchoLevels& levels) {
  ++frames_version_;  // also where the old frames are freed and the new ones fail
  if (!frames_.suits(volume)) {
    if (auto made = replace_frames(volume); !made) return made;
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

Result<bool> VolumeInFlight::prepare_ahead(const Scene& scene, const EchoLevels& levels) {
  if (!frames_gone_) return false;
  if (auto begun = begin_frames(scene, levels); !begun) return begun.error();
  if (!frames_.prepares_single_frames() || frames_.done()) return false;
  if (auto submitted = view_.prepare_ahead(bindings()); !submitted) return submitted.error();
  return true;
}

Result<void> VolumeInFlight::begin_cast(const Scene& scene) {
  if (auto begun = begin_frames(scene, levels_); !begun) return begun;
  frames_gone_ = false;
  changed_.reset();
  changed_beyond_ = false;
  note_cast();
  return view_.begin_cast(scene, bindings());
}

Result<void> VolumeInFlight::begin_frames(const Scene& scene, const EchoLevels& levels) {
  const Scene::Speckle options = effective(scene, levels).speckle;
  if (auto begun = frames_.begin(*device_.gpu, *device_.pipelines, options); !begun) return begun;
  if (frames_.bindings_changed()) bind_view();
  if (!frames_.done()) ++frames_version_;
  return {};
}

}  // namespace fanlight
