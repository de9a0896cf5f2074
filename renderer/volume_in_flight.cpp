// SPDX-License-Identifier: Apache-2.0
#include "renderer/volume_in_flight.hpp"

#include <algorithm>
#include <utility>

namespace fanlight {

Result<VolumeInFlight> VolumeInFlight::create(const PassDevice& device, const Config& config,
                                              const PassDevice* light) {
  VolumeInFlight made(device, config);
  // Where the processor casts, what follows the rays may never be submitted.
  auto angles =
      AngleBuffer::create(*device.gpu, made.table_.entries().size(),
                          config.ray_workers != nullptr ? BufferPlace::kToGpu : BufferPlace::kDevice);
  if (!angles) return angles.error();
  made.angles_ = std::move(*angles);
  if (auto frames = made.create_frames(config.geometry, config.usual_frames); !frames) return frames.error();
  if (auto passes = made.create_passes(light); !passes) return passes.error();
  return made;
}

Result<void> VolumeInFlight::create_passes(const PassDevice* light_device) {
  reads_in_place_ = light_device == nullptr && config_.ray_workers == nullptr;
  auto cast = CastPass::create(device_, {.size = config_.size,
                                         .largest = config_.largest,
                                         .band_samples = config_.band_samples,
                                         .skipping = config_.skipping,
                                         .counting = config_.counting,
                                         .pauses = config_.ray_workers != nullptr,
                                         .maps_for_host = !reads_in_place_,
                                         .ray_workers = config_.ray_workers});
  if (!cast) return cast.error();
  cast_ = std::move(*cast);
  cast_.bind(bindings());
  using Copies = LightPass::Config::Copies;
  auto light = LightPass::create(light_device == nullptr ? device_ : *light_device,
                                 {.largest = config_.largest,
                                  .copies = reads_in_place_ ? Copies::kNone : Copies::kByHost,
                                  .skipping = config_.skipping,
                                  .workers = config_.ray_workers});
  if (!light) return light.error();
  light_ = std::move(*light);
  if (reads_in_place_) return {};
  auto steady = GpuBuffer::create(*device_.gpu, "steady copy", light_.steady().bytes(),
                                  VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, BufferPlace::kToGpu);
  if (!steady) return steady.error();
  steady_copy_ = std::move(*steady);
  return {};
}

void VolumeInFlight::follow(const VolumeInFlight& other) {
  light_.follow(other.light_.steady());
  light_.set_reader(other.light_.recorder().timeline());
}

Result<void> VolumeInFlight::light(const Scene& scene, const Earlier& earlier, const Earlier& before) {
  if (reads_in_place_) {
    light_.read(cast_);
  } else {
    light_.copy_by_host(cast_);
  }
  std::optional<Seam> seam;
  if (before && new_frames_.count() > 0 && scene.filter.seam_frames > 0)
    seam = {.earlier = *before,
            .frames = new_frames_,
            .frame_step_rad = extent_.frame_step_rad(),
            .motor_radius_mm = geometry_.motor_radius_mm};
  if (auto begun = light_.begin(effective(scene), earlier, seam ? &*seam : nullptr); !begun) return begun;
  return reads_in_place_ ? light_.submit_all() : light_.submit_next();
}

Result<void> VolumeInFlight::light_next_piece(const Scene* changed) {
  if (changed != nullptr) {
    if (auto done = light_.change(effective(*changed)); !done) return done;
  }
  return light_.submit_next();
}

Result<void> VolumeInFlight::retry_held() {
  auto retried = cast_.recorder().retry_held();
  return retried ? light_.recorder().retry_held() : retried;
}

void VolumeInFlight::drop_held() {
  cast_.drop_held();
  light_.recorder().drop_held();
}

std::array<StageSpan, kStages> VolumeInFlight::stage_spans() const {
  auto spans = light_.stage_spans();
  if (!light_.is_first_of_cast()) return spans;
  // Two devices count on the clock of the one processor.
  const auto cast = cast_.stage_spans();
  for (const Stage stage : {Stage::kPrepare, Stage::kUpload, Stage::kCast}) {
    const auto index = static_cast<std::size_t>(stage);
    spans[index] = cast[index];
  }
  return spans;
}

/// As stage_ms(), without the weights. The upload is part of the cast.
std::array<double, kStages> VolumeInFlight::sums_of_pieces_ms() const {
  auto ms = light_.stage_ms();
  if (!light_.is_first_of_cast()) return ms;
  const auto cast_ms = cast_.recorder().stage_ms();
  for (const Stage stage : {Stage::kPrepare, Stage::kCast})
    ms[static_cast<std::size_t>(stage)] = cast_ms[static_cast<std::size_t>(stage)];
  return ms;
}

std::array<double, kStages> VolumeInFlight::stage_ms() const {
  std::array<double, kStages> ms{};
  std::ranges::transform(stage_spans(), ms.begin(), &StageSpan::ms);
  // What the processor runs in between for another volume does not count.
  if (light_.lights_here()) ms = sums_of_pieces_ms();
  constexpr auto kFilter = static_cast<std::size_t>(Stage::kFilter);
  if (light_.is_first_of_cast()) ms[kFilter] += cast_.recorder().stage_ms()[kFilter];  // the weights
  return ms;
}

Result<DepthMaps> VolumeInFlight::read_depth() {
  auto maps = cast_.read_maps();
  if (maps) maps->smooth_mm.assign(depth_mm().begin(), depth_mm().end());
  return maps;
}

const GpuBuffer& VolumeInFlight::steady_for_private_views() const {
  if (reads_in_place_) return light_.steady();
  const std::size_t bytes = light_.size().pixels() * sizeof(glm::vec2);
  std::ranges::copy(light_.steady().mapped().first(bytes), steady_copy_.mapped().begin());
  return steady_copy_;
}

Result<void> VolumeInFlight::create_frames(const FanGeometry& geometry, std::uint32_t frames) {
  auto made = FrameStore::create(device_, {.columns = geometry.columns,
                                           .rows = geometry.rows,
                                           .frame_capacity = frames,
                                           .zero_is_unscanned = geometry.zero_is_unscanned,
                                           .piece_samples = config_.band_samples,
                                           .sampling = config_.sampling,
                                           .workers = config_.workers});
  if (!made) return made.error();
  frames_ = std::move(*made);
  return {};
}

Result<void> VolumeInFlight::replace_frames(const Volume& volume) {
  frames_ = FrameStore(device_);  // frees the memory first: two of the largest volumes may not fit
  // The sweeps of a motor vary in length. Spare room avoids an allocation for the next longer sweep.
  const std::uint32_t frames = volume.stamp().frames;
  const std::uint32_t with_spare = std::min(frames + frames / 8, config_.frame_capacity);
  auto made = create_frames(volume.geometry(), std::max(frames, with_spare));
  bind_cast();
  return made;
}

void VolumeInFlight::bind_cast() {
  ++bindings_version_;
  cast_.bind(bindings());
}

Result<void> VolumeInFlight::prepare(const Scene& scene) {
  geometry_ = config_.geometry;
  const Scene known = effective(scene, {});
  if (auto begun = frames_.begin(known.speckle); !begun) return begun;
  bind_cast();
  return cast_.find_pipelines(known, geometry_);
}

Result<void> VolumeInFlight::load(const Volume& volume, const EchoLevels& levels,
                                  const NearTissueSearch& near_tissue) {
  ++frames_version_;  // also where the old frames are freed and the new ones fail
  if (!frames_.suits(volume)) {
    if (auto made = replace_frames(volume); !made) return made;
  }
  frames_.load(volume);
  new_frames_ = {};
  geometry_ = volume.geometry();
  levels_ = levels;
  near_tissue_ = near_tissue;
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
  if (!frames_gone_ || !has_frame_memory()) return false;
  if (auto begun = begin_frames(scene, levels); !begun) return begun.error();
  if (!frames_.prepares_single_frames() || frames_.done()) return false;
  if (auto submitted = cast_.prepare_ahead(bindings()); !submitted) return submitted.error();
  return true;
}

Result<void> VolumeInFlight::begin_cast(const Scene& scene) {
  if (auto begun = begin_frames(scene, levels_); !begun) return begun;
  frames_gone_ = false;
  changed_.reset();
  changed_beyond_ = false;
  return cast_.begin(scene, bindings());
}

Result<void> VolumeInFlight::begin_frames(const Scene& scene, const EchoLevels& levels) {
  const Scene::Speckle options = effective(scene, levels).speckle;
  if (auto begun = frames_.begin(options); !begun) return begun;
  if (frames_.bindings_changed()) bind_cast();
  if (!frames_.done()) ++frames_version_;
  return {};
}

std::uint32_t VolumeInFlight::nearest_frame_index(double angle_rad) const {
  const auto above = std::ranges::lower_bound(angles_rad_, angle_rad);
  if (above == angles_rad_.begin()) return 0;
  const bool below_is_nearer = above == angles_rad_.end() || angle_rad - above[-1] < *above - angle_rad;
  return static_cast<std::uint32_t>(above - angles_rad_.begin()) - (below_is_nearer ? 1 : 0);
}

void VolumeInFlight::mark_changed(std::uint32_t frame_index) {
  const CastPass::FrameRange single{frame_index, frame_index};
  const CastPass::FrameRange known = changed_.value_or(single);
  changed_ = CastPass::FrameRange{std::min(known.first, frame_index), std::max(known.last, frame_index)};
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
  new_frames_.add(angle_rad);
  ++frames_version_;
  if (angles_rad_[frame_index] != angle_rad) {
    // The first and the last angle bound the fan, and so the length of every ray.
    changed_beyond_ |= frame_index == 0 || frame_index + 1 == angles_rad_.size();
    angles_rad_[frame_index] = angle_rad;
    update_angles();
  }
  volume_.last_frame_sequence = frame.stamp.sequence;
  volume_.last_recorded_number = frame.stamp.number_in_recording();
  volume_.last_capture_time_ns = frame.stamp.capture_time_ns;
  return true;
}

Result<void> VolumeInFlight::complete(const Volume& volume, const EchoLevels& levels,
                                      const NearTissueSearch& near_tissue) {
  const auto frames = static_cast<std::uint32_t>(angles_rad_.size());
  const bool same_layout =
      frames_.suits(volume) && volume.geometry() == geometry_ && volume.stamp().frames == frames;
  const auto order = volume.by_angle();
  bool same_angles = same_layout;
  for (std::uint32_t frame_index = 0; same_layout && frame_index < frames; ++frame_index) {
    if (!frames_.holds(frame_index, volume.commit_numbers()[order[frame_index]])) mark_changed(frame_index);
    same_angles &= angles_rad_[frame_index] == volume.angles_rad()[order[frame_index]];
  }
  changed_beyond_ |= !same_angles || levels != levels_ || near_tissue != near_tissue_;
  // The last frames are still blended, and so are those that come with the volume only.
  if (same_layout && new_frames_.count() > 0) add_missing_frames(volume);
  const NewFrames kept = same_layout ? new_frames_ : NewFrames{};
  auto loaded = load(volume, levels, near_tissue);
  new_frames_ = kept;
  return loaded;
}

/// Notes the frames of the volume that replace() did not get as new ones, in the order of their arrival.
void VolumeInFlight::add_missing_frames(const Volume& volume) {
  const auto order = volume.by_angle();
  const auto angles_rad = volume.angles_rad();
  for (std::uint32_t arrival = 0; arrival < volume.stamp().frames; ++arrival) {
    const auto at = std::ranges::lower_bound(order, angles_rad[arrival], {},
                                             [&](std::uint32_t index) { return angles_rad[index]; });
    const auto frame_index = static_cast<std::uint32_t>(at - order.begin());
    if (!frames_.holds(frame_index, volume.commit_numbers()[arrival])) new_frames_.add(angles_rad[arrival]);
  }
}

Result<void> VolumeInFlight::recast(const Scene& scene) {
  if (auto begun = begin_frames(scene, levels_); !begun) return begun;
  frames_gone_ = false;
  return cast_.recast(bindings(), *std::exchange(changed_, {}));
}

}  // namespace fanlight
