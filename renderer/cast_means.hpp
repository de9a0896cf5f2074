// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "renderer/pipelines/pipelines.hpp"
#include "renderer/schedule/watchdog.hpp"
#include "renderer/volume/render_workers.hpp"
#include "renderer/vulkan/gpu.hpp"
#include "renderer/vulkan/render_device.hpp"

namespace fanlight {

/// How passes 0 and 1 run on a device, as suits it.
struct CastMeans {
  /// `wanted`: absent: the one that suits the device and volumes of `longest_side` voxels. Where a later
  /// volume is too large for the textures of a GPU, it is refused. `rays_by_shader`: as Renderer::Config.
  CastMeans(const Gpu& gpu, std::optional<Sampling> wanted, std::uint32_t longest_side, bool rays_by_shader);

  Sampling sampling;
  std::uint64_t band_samples;              ///< approximate limit of samples in a band of pass 1
  std::unique_ptr<RenderWorkers> workers;  ///< null where the GPU runs pass 0
  bool casts_here;                         ///< the workers cast the rays

  RenderWorkers* ray_workers() const { return casts_here ? workers.get() : nullptr; }
  /// Of private views: smaller, since the main view waits for their bands.
  std::uint64_t private_band_samples() const;
};

/// How the device of a live renderer is opened. On a processor passes 2 and 3 get a device of their own only
/// where shaders run them; else Renderer ignores such a device.
DeviceOptions live_device_options();

/// How long a device may take.
Watchdog::Limits usual_limits(const Gpu& gpu);

}  // namespace fanlight
