#include "renderer/render_slot.hpp"

#include <algorithm>
#include <utility>

namespace fanlight {

Result<RenderSlot> RenderSlot::create(const Gpu& gpu, const Passes& passes, const Config& config) {
  RenderSlot made(config);
  auto angles = AngleBuffer::create(gpu, made.table_.entries().size_bytes());
  if (!angles) return angles.error();
  made.angles_ = std::move(*angles);
  if (auto step = made.create_frames(gpu, config.geometry, config.usual_frames); !step) return step.error();
  auto view = VolumeView::create(
      gpu, passes, {.size = config.size, .band_samples = config.band_samples, .skipping = config.skipping});
  if (!view) return view.error();
  made.view_ = std::move(*view);
  made.view_.see(gpu, made.seen());
  return made;
}

Result<void> RenderSlot::create_frames(const Gpu& gpu, const FanGeometry& geometry, std::uint32_t frames) {
  auto made = FrameStore::create(gpu, {.columns = geometry.columns,
                                       .rows = geometry.rows,
                                       .frame_capacity = frames,
                                       .piece_samples = config_.band_samples,
                                       .sampling = config_.sampling});
  if (!made) return made.error();
  frames_ = std::move(*made);
  return {};
}

Result<void> RenderSlot::replace_frames(const Gpu& gpu, const Volume& volume) {
  frames_ = FrameStore();  // first, so that a volume as large as the GPU takes still has room
  // A motor's sweeps are not all of one length: with some room to spare the next longer one needs no memory.
  const std::uint32_t frames = volume.stamp().frames;
  const std::uint32_t roomy = std::min(frames + frames / 8, config_.frame_capacity);
  auto made = create_frames(gpu, volume.geometry(), std::max(frames, roomy));
  view_.see(gpu, seen());
  return made;
}

Result<void> RenderSlot::prepare(const Gpu& gpu, Passes& passes, const Scene& scene) {
  geometry_ = config_.geometry;
  if (auto begun = frames_.begin(gpu, passes, scene.speckle); !begun) return begun;
  view_.see(gpu, seen());
  return view_.find_cast_pipelines(passes, scene, geometry_.kind);
}

Result<void> RenderSlot::load(const Gpu& gpu, const Volume& volume) {
  ++frames_turn_;  // also where the frames are gone and no others come
  if (!frames_.suits(volume)) {
    if (auto made = replace_frames(gpu, volume); !made) return made;
  }
  frames_.load(volume);
  geometry_ = volume.geometry();
  angles_rad_.clear();
  for (const std::uint32_t index : volume.by_angle()) angles_rad_.push_back(volume.angles_rad()[index]);
  place_angles();
  volume_ = volume.stamp();
  return {};
}

void RenderSlot::place_angles() {
  if (table_.place(angles_rad_)) angles_.put(table_.entries());
  extent_ = {.first_angle_rad = angles_rad_.front(),
             .last_angle_rad = angles_rad_.back(),
             .frames = static_cast<std::uint32_t>(angles_rad_.size()),
             .frame_capacity = frames_.frame_capacity()};
}

void RenderSlot::stage(const FanGeometry& geometry, std::uint32_t place, std::uint32_t frames,
                       std::uint64_t arrival, std::span<const std::uint8_t> pixels) {
  if (!frames_.suits(geometry) || std::max(place + 1, frames) > frames_.frame_capacity()) return;
  ++frames_turn_;
  frames_.stage(place, frames, arrival, pixels);
  frames_gone_ = true;
}

Result<bool> RenderSlot::prepare_ahead(const Gpu& gpu, Passes& passes, const Scene::Speckle& options) {
  if (!frames_gone_) return false;
  if (auto begun = begin_frames(gpu, passes, options); !begun) return begun.error();
  if (!frames_.prepares_single_frames() || frames_.done()) return false;
  if (auto submitted = view_.prepare_ahead(gpu, passes, seen()); !submitted) return submitted.error();
  return true;
}

Result<void> RenderSlot::begin_cast(const Gpu& gpu, Passes& passes, const Scene& scene) {
  if (auto begun = begin_frames(gpu, passes, scene.speckle); !begun) return begun;
  frames_gone_ = false;
  changed_.reset();
  changed_beyond_ = false;
  return view_.begin_cast(gpu, passes, scene, seen());
}

Result<void> RenderSlot::begin_frames(const Gpu& gpu, Passes& passes, const Scene::Speckle& options) {
  if (auto begun = frames_.begin(gpu, passes, options); !begun) return begun;
  if (frames_.bindings_changed()) view_.see(gpu, seen());
  if (!frames_.done()) ++frames_turn_;
  return {};
}

}  // namespace fanlight
