// SPDX-License-Identifier: Apache-2.0
#include "server/bench/rig.hpp"

#include <utility>

#include "proto/base/clock.hpp"

namespace fanlight {

namespace {

constexpr std::int64_t kSecondNs = 1'000'000'000;

}  // namespace

Result<void> BenchRig::start(Skipping skipping) {
  const SourceDescription& source = volumes_.description();
  const auto side = static_cast<std::uint32_t>(picture_);
  auto made = Renderer::create({.size = {side, side},
                                .geometry = source.geometry,
                                .first_angle_rad = source.first_angle_rad,
                                .last_angle_rad = source.last_angle_rad,
                                .frame_capacity = volumes_.frame_capacity(),
                                .skipping = skipping},
                               {.gpu = gpu_, .counters = counters_}, scene_);
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
    if (!renderer_->busy()) return Error{ErrorCode::kUnavailable, "no picture came of what was shown"};
    if (auto waited = renderer_->wait(kSecondNs); !waited) return waited.error();
  }
}

}  // namespace fanlight
