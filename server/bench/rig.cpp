// SPDX-License-Identifier: Apache-2.0
#include "server/bench/rig.hpp"

#include <utility>

#include "proto/base/clock.hpp"

namespace fanlight {

namespace {

constexpr std::int64_t kSecondNs = 1'000'000'000;

}  // namespace

Result<void> BenchRig::start(Skipping skipping, Counting counting) {
  const SourceDescription& source = volumes_.description();
  const auto side = static_cast<std::uint32_t>(picture_);
  auto made = Renderer::create(
      {.size = {side, side},
       .geometry = source.geometry,
       .first_angle_rad = source.first_angle_rad,
       .last_angle_rad = source.last_angle_rad,
       .frame_capacity = volumes_.frame_capacity(),
       .skipping = skipping,
       .counting = counting},
      {.gpu = *device_.gpu, .counters = counters_, .light_gpu = device_.light_gpu.get()}, scene_);
  if (!made) return made.error();
  renderer_ = std::move(*made);
  return {};
}

Result<double> BenchRig::whole_volume() {
  const Volume& volume = volumes_.next();
  const std::int64_t from_ns = now_ns();
  if (auto loaded = renderer_->load(volume); !loaded) return loaded.error();
  return picture_since(from_ns);
}

Result<double> BenchRig::new_volume() {
  const Volume& volume = volumes_.next();
  const std::uint32_t frames = volume.stamp().frames;
  for (std::uint32_t index = 0; index + 1 < frames; ++index) {
    if (auto taken = take(index); !taken) return taken.error();
  }
  const std::int64_t from_ns = now_ns();
  if (auto loaded = renderer_->load(volume); !loaded) return loaded.error();
  return picture_since(from_ns);
}

Result<std::vector<double>> BenchRig::rolling_sweep() {
  std::vector<double> each_ms;
  const Volume& volume = volumes_.next();
  for (std::uint32_t index = 0; index < volume.stamp().frames; ++index) {
    const std::int64_t from_ns = now_ns();
    renderer_->take_frame(volumes_.frame(index));
    if (auto advanced = renderer_->advance(); !advanced) return advanced.error();
    if (!renderer_->busy()) continue;  // it has no index in the last sweep, and is loaded with its volume
    const auto picture_ms = picture_since(from_ns);
    if (!picture_ms) return picture_ms.error();
    each_ms.push_back(*picture_ms);
  }
  return each_ms;
}

Result<double> BenchRig::change(void (*how)(Scene&, double sign)) {
  sign_ = -sign_;
  how(scene_.scene, sign_);
  ++scene_.revision;
  const std::int64_t from_ns = now_ns();
  renderer_->show(scene_);
  return picture_since(from_ns);
}

Result<double> BenchRig::private_pictures(std::size_t views, PrivateKind kind) {
  PrivateViews wanted{};
  for (std::size_t index = 0; index < views; ++index) {
    auto& mailbox = private_pictures_[index];
    if (!mailbox) mailbox.emplace(private_bell_);
    mailbox->newest();  // nothing old is left
    NumberedScene scene{.revision = 1, .scene = scene_.scene};
    const double other = 5.0 * static_cast<double>(index + 1);
    (kind == PrivateKind::kCamera ? scene.scene.camera.yaw_deg : scene.scene.light.right_mm) += other;
    wanted[index] = {.view_id = ++private_view_id_,
                     .scene = scene,
                     .own_camera = kind == PrivateKind::kCamera,
                     .pictures = &*mailbox};
  }
  const std::int64_t from_ns = now_ns();
  if (auto set = renderer_->want(wanted); !set) return set.error();
  for (std::size_t drawn = 0; drawn < views;) {
    if (renderer_->collect_private()) {
      for (std::size_t index = 0; index < views; ++index) {
        if (private_pictures_[index]->newest() != nullptr) ++drawn;
      }
      continue;
    }
    if (renderer_->busy()) {
      if (auto waited = renderer_->wait(kSecondNs); !waited) return waited.error();
      continue;
    }
    const auto advanced = renderer_->advance_private();
    if (!advanced) return advanced.error();
    if (!*advanced) return Error{ErrorCode::kUnavailable, "a private view got no picture"};
  }
  const double ms = static_cast<double>(now_ns() - from_ns) / 1e6;
  if (auto closed = renderer_->want({}); !closed) return closed.error();
  return ms;
}

Result<void> BenchRig::take(std::uint32_t index) {
  while (!renderer_->wants_frame()) {
    if (auto waited = renderer_->wait(kSecondNs); !waited) return waited;
  }
  renderer_->take_frame(volumes_.frame(index));
  if (auto advanced = renderer_->advance(); !advanced) return advanced;
  return renderer_->wait(kSecondNs);
}

Result<double> BenchRig::picture_since(std::int64_t from_ns) {
  for (;;) {
    if (auto advanced = renderer_->advance(); !advanced) return advanced.error();
    if (renderer_->collect(shown_)) return static_cast<double>(now_ns() - from_ns) / 1e6;
    if (!renderer_->busy()) return Error{ErrorCode::kUnavailable, "no picture was rendered"};
    if (auto waited = renderer_->wait(kSecondNs); !waited) return waited.error();
  }
}

}  // namespace fanlight
