// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <optional>

#include "renderer/renderer.hpp"

namespace fanlight::test {

/// How pass 1 works. The pictures do not depend on it.
struct Casting {
  Skipping skipping = Skipping::kOn;
  std::optional<Sampling> sampling;
  std::optional<BufferAccess> access;
};

/// Provides one GPU per process, with the Vulkan validation layers on. A test fails if the layers have
/// reported a message by its end.
class GpuTest : public testing::Test {
 protected:
  static const Gpu& gpu() { return *rig().gpu; }
  /// The same, or a second device that reads buffers in the other way.
  static const Gpu& gpu(BufferAccess access) {
    if (gpu().buffer_access() == access) return gpu();
    if (!has_useful_texels(gpu().limits())) return gpu();  // there is no other way
    static const std::unique_ptr<Gpu> other = [access] {
      auto found = Gpu::create(*rig().instance, "", access);
      if (!found) throw std::runtime_error(found.error().message);
      return std::move(*found);
    }();
    return *other;
  }

  void TearDown() override {
    EXPECT_EQ(rig().instance->validation_messages(), 0U)
        << "the validation layers reported messages, see above";
  }

  /// A renderer for sweeps of `angles_rad` with the scene as revision 1. Throws if it cannot be created.
  static std::unique_ptr<Renderer> made_renderer(const FanGeometry& geometry,
                                                 std::span<const double> angles_rad, PictureSize size,
                                                 const Scene& scene, RenderCounters& counters,
                                                 const Casting& casting = {}) {
    const auto [first, last] = std::ranges::minmax(angles_rad);
    auto renderer =
        Renderer::create({.size = size,
                          .geometry = geometry,
                          .first_angle_rad = first,
                          .last_angle_rad = last,
                          .frame_capacity = static_cast<std::uint32_t>(angles_rad.size()),
                          .skipping = casting.skipping,
                          .sampling = casting.sampling},
                         {.gpu = casting.access ? gpu(*casting.access) : gpu(), .counters = counters},
                         {.revision = 1, .scene = scene});
    if (!renderer) throw std::runtime_error(renderer.error().message);
    return std::move(*renderer);
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
  struct Rig {
    std::unique_ptr<GpuInstance> instance;
    std::unique_ptr<Gpu> gpu;
  };
  static const Rig& rig() {
    static const Rig made = [] {
      auto instance = GpuInstance::create({.validation = true});
      if (!instance) throw std::runtime_error(instance.error().message);
      auto found = Gpu::create(**instance, "");
      if (!found) throw std::runtime_error(found.error().message);
      return Rig{std::move(*instance), std::move(*found)};
    }();
    return made;
  }
};

}  // namespace fanlight::test
