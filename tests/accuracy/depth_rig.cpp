// SPDX-License-Identifier: Apache-2.0
#include "tests/accuracy/depth_rig.hpp"

#include <stdexcept>
#include <utility>

namespace fanlight::test {

namespace {

void must(Result<void> done) {
  if (!done) throw std::runtime_error(done.error().message);
}

template <typename T>
T made(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message);
  return std::move(*result);
}

}  // namespace

BareGpu::BareGpu(const std::string& name)
    : instance_(made(GpuInstance::create({}))), gpu_(made(Gpu::create(*instance_, name))) {}

DepthRig::DepthRig(BareGpu& gpu, const ScannedFan& fan, std::uint32_t frames, PictureSize size)
    : renderer_(made(Renderer::create(
          {.size = size,
           .geometry = fan.geometry,
           .first_angle_rad = fan.first_angle_rad,
           .last_angle_rad = fan.last_angle_rad,
           .frame_capacity = frames},
          {.gpu = gpu.gpu(), .counters = counters_, .store = &gpu.pipelines()},
          {.revision = 0, .scene = scene_for(fan.geometry, fan.first_angle_rad, fan.last_angle_rad)}))) {}

DepthMaps DepthRig::depths(Scene scene) {
  renderer_->show({.revision = ++revision_, .scene = std::move(scene)});
  // After show(), so that the volume is cast only once, with this scene.
  if (const Volume* volume = std::exchange(next_volume_, nullptr)) must(renderer_->load(*volume));
  run_until_shown();
  return made(renderer_->read_depth());
}

void DepthRig::run_until_shown() {
  constexpr std::int64_t kSecondNs = 1'000'000'000;
  for (bool shown = false;;) {
    must(renderer_->advance());
    while (renderer_->collect(picture_)) shown = picture_.stamp.scene_revision == revision_;
    if (!renderer_->busy()) {
      if (shown) return;
      must(renderer_->advance());
      if (!renderer_->busy()) throw std::runtime_error("nothing is under way, so no picture will come");
    }
    must(renderer_->wait(kSecondNs));
  }
}

}  // namespace fanlight::test
