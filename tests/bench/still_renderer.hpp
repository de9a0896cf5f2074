// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "acquisition/phantom/phantom_source.hpp"
#include "renderer/renderer.hpp"

namespace fanlight {

/// A renderer with one volume of the simulated probe, for programs that time its stages. Ends the program
/// with the error's text where anything fails.
class StillRenderer {
 public:
  explicit StillRenderer(PhantomSource::Config config) {
    config.pace = PhantomSource::Pace::kUnpaced;
    const auto source = required(PhantomSource::create(config));
    const SourceDescription& description = source->description();
    Volume volume(description.geometry, description.frames_per_volume);
    while (!volume.full()) {
      const auto frame = source->next_frame({});
      source->read_pixels(volume.next_frame_pixels(), {});
      volume.add_frame(**frame);
    }
    volume.sort_by_angle();
    volume.stamp().volume_id = 1;
    instance_ = required(GpuInstance::create({}));
    gpu_ = required(Gpu::create(*instance_, ""));
    shown_ = {
        .revision = 1,
        .scene = scene_for(description.geometry, description.first_angle_rad, description.last_angle_rad)};
    renderer_ = required(Renderer::create({.size = {},
                                           .geometry = description.geometry,
                                           .first_angle_rad = description.first_angle_rad,
                                           .last_angle_rad = description.last_angle_rad,
                                           .frame_capacity = description.frames_per_volume},
                                          {.gpu = *gpu_, .counters = counters_}, shown_));
    if (auto loaded = renderer_->load(volume); !loaded) fail(loaded.error());
    next_picture();
  }

  /// The scene that frames the whole fan.
  const Scene& scene() const { return shown_.scene; }
  std::string device() const { return gpu_->candidate().name; }

  /// The picture of the volume with this scene.
  Picture show(const Scene& scene) {
    renderer_->show({.revision = ++shown_.revision, .scene = scene});
    return next_picture();
  }

 private:
  [[noreturn]] static void fail(const Error& error) {
    fmt::print(stderr, "{}\n", error.message);
    std::exit(1);
  }

  template <typename T>
  static T required(Result<T> result) {
    if (!result) fail(result.error());
    return std::move(result).value();
  }

  Picture next_picture() {
    Picture picture;
    for (;;) {
      if (auto advanced = renderer_->advance(); !advanced) fail(advanced.error());
      if (renderer_->collect(picture)) return picture;
      if (auto waited = renderer_->wait(1'000'000'000); !waited) fail(waited.error());
    }
  }

  std::unique_ptr<GpuInstance> instance_;
  std::unique_ptr<Gpu> gpu_;
  RenderCounters counters_;
  NumberedScene shown_;
  std::unique_ptr<Renderer> renderer_;
};

inline double median(std::vector<double> values) {
  std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2));
  return values[values.size() / 2];
}

inline double stage_ms(const Picture& picture, Stage stage) {
  return picture.stamp.stage_ms[static_cast<std::size_t>(stage)];
}

}  // namespace fanlight
