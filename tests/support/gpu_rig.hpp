// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <optional>
#include <stdexcept>

#include "renderer/renderer.hpp"

namespace fanlight::test {

/// How pass 1 works. The pictures do not depend on it.
struct Casting {
  Skipping skipping = Skipping::kOn;
  std::optional<Sampling> sampling;
  bool rays_by_shader = false;
  std::optional<BufferAccess> access;
  /// Of a processor, so that a GPU casts in several bands too.
  std::uint64_t band_samples = 8'000'000;
  /// Where shaders light on a processor, passes 2 and 3 have a device of their own, as in `fanlight serve`.
  bool own_light_device = true;
  /// The largest picture; absent: of the usual size.
  std::optional<PictureSize> largest_size;
};

/// One of the ways in which a processor may cast rays: by vectors, or by one of two shaders.
inline Casting way_of_casting(std::uint32_t number) {
  switch (number % 3) {
    case 0:
      return {.sampling = Sampling::kGathering};
    case 1:
      return {.sampling = Sampling::kGathering, .rays_by_shader = true};
    default:
      return {.sampling = Sampling::kTexture};
  }
}

/// The devices of this process, with the Vulkan validation layers on. With FANLIGHT_TEST_AS_GPU in the
/// environment, a driver on the processor counts as a GPU. They are opened where a test first asks for them,
/// and closed before the process ends: the layers do not outlive its static objects.
class GpuRig : public testing::Environment {
 public:
  /// The value; throws the error.
  template <typename T>
  static T required(Result<T> result) {
    if (!result) throw std::runtime_error(result.error().message);
    return std::move(*result);
  }

  const Gpu& gpu() { return opened(gpu_, std::nullopt); }
  const Gpu& gpu(BufferAccess access) {
    return gpu().buffer_access() == access ? gpu() : opened(other_gpu_, access);
  }
  const Gpu& light_gpu(BufferAccess access) {
    return opened(light_gpus_[static_cast<std::size_t>(access)], access);
  }
  std::uint64_t messages() const { return messages_.value(); }

  /// Shared by all renderers on these devices: building the pipelines takes longer than most tests.
  PipelineStore& pipelines() { return pipelines_; }

  void TearDown() override {
    pipelines_.clear();
    for (Opened* const each : {&light_gpus_[0], &light_gpus_[1], &other_gpu_, &gpu_}) {
      each->gpu.reset();
      each->instance.reset();
    }
    EXPECT_EQ(messages(), 0U) << "the validation layers reported messages, see above";
  }

 private:
  struct Opened {
    std::unique_ptr<GpuInstance> instance;
    std::unique_ptr<Gpu> gpu;
  };
  const Gpu& opened(Opened& device, std::optional<BufferAccess> access) {
    if (device.gpu == nullptr) {
      // NOLINTNEXTLINE(concurrency-mt-unsafe): nothing here writes the environment.
      const bool as_gpu = std::getenv("FANLIGHT_TEST_AS_GPU") != nullptr;
      device.instance = required(
          GpuInstance::create({.validation = true, .messages = &messages_, .processor_as_gpu = as_gpu}));
      device.gpu = required(Gpu::create(*device.instance, "", access));
    }
    return *device.gpu;
  }

  Counter messages_;
  Opened gpu_;
  Opened other_gpu_;
  std::array<Opened, 2> light_gpus_;
  PipelineStore pipelines_;
};
inline GpuRig& gpu_rig = static_cast<GpuRig&>(*testing::AddGlobalTestEnvironment(new GpuRig));

/// Tests with one GPU per process. A test fails if the validation layers have reported a message by its end.
class GpuTest : public testing::Test {
 protected:
  static const Gpu& gpu() { return gpu_rig.gpu(); }
  /// The same, or a second device that reads buffers in the other way.
  static const Gpu& gpu(BufferAccess access) {
    const bool has_choice = has_useful_texels(gpu().limits());
    return has_choice ? gpu_rig.gpu(access) : gpu();
  }

  void TearDown() override {
    EXPECT_EQ(gpu_rig.messages(), messages_before_) << "the validation layers reported messages, see above";
  }

  /// A renderer for sweeps of `angles_rad` with the scene as revision 1. Throws if it cannot be created.
  static std::unique_ptr<Renderer> made_renderer(const FanGeometry& geometry,
                                                 std::span<const double> angles_rad, PictureSize size,
                                                 const Scene& scene, RenderCounters& counters,
                                                 const Casting& casting = {}) {
    const auto [first, last] = std::ranges::minmax(angles_rad);
    const Gpu& chosen = casting.access ? gpu(*casting.access) : gpu();
    const bool apart = casting.own_light_device && chosen.candidate().kind == kProcessorKind;
    const Gpu* const lights = apart ? &gpu_rig.light_gpu(chosen.buffer_access()) : nullptr;
    return GpuRig::required(

        Renderer::create(
            {.size = size,
             .largest_size = casting.largest_size,
             .geometry = geometry,
             .first_angle_rad = first,
             .last_angle_rad = last,
             .frame_capacity = static_cast<std::uint32_t>(angles_rad.size()),
             .skipping = casting.skipping,
             .sampling = casting.sampling,
             .rays_by_shader = casting.rays_by_shader,
             .band_samples = casting.band_samples},
            {.gpu = chosen, .counters = counters, .light_gpu = lights, .store = &gpu_rig.pipelines()},
            {.revision = 1, .scene = scene}));
  }

  /// Advances the renderer until it has finished a picture, and returns the picture. Blocks. Throws on errors
  /// and when the renderer is idle, because no picture would follow.
  static Picture next_picture(Renderer& renderer) {
    Picture picture;
    for (;;) {
      if (auto advanced = renderer.advance(); !advanced) throw std::runtime_error(advanced.error().message);
      if (renderer.collect(picture)) return picture;
      if (!renderer.busy()) throw std::runtime_error("the renderer is idle, so no picture will follow");
      if (auto waited = renderer.wait(1'000'000'000); !waited)
        throw std::runtime_error(waited.error().message);
    }
  }

 private:
  std::uint64_t messages_before_ = gpu_rig.messages();
};

}  // namespace fanlight::test
