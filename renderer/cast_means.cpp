// SPDX-License-Identifier: Apache-2.0
#include "renderer/cast_means.hpp"

#include "renderer/rays/ray_caster.hpp"

namespace fanlight {

namespace {

// Samples in a band of pass 1: some 30 ms of work on lavapipe, and much less on a GPU or where the processor
// casts the rays. On one device a changed light waits for one band, and late in a cast for a piece of pass 0;
// so does the end of the process.
constexpr std::uint64_t kProcessorBand = 8'000'000;
constexpr std::uint64_t kGpuBand = 500'000'000;
// A private view's bands are smaller by this factor, since the main view waits for them.
constexpr std::uint64_t kPrivateBandDivisor = 4;

// A driver of a GPU resets it after a few seconds by itself, and then says so. A processor that renders has
// no such limit, shares its time with everything else on the machine, and compiles shaders within a
// submission.
constexpr std::int64_t kProcessorHungNs = 30'000'000'000;

bool is_processor(const Gpu& gpu) {
  return gpu.candidate().kind == kProcessorKind;
}

/// Some GPUs limit textures to 2048 voxels each way, fewer than scan lines may have samples. Buffers have no
/// such limit.
Sampling suitable_sampling(const Gpu& gpu, std::uint32_t longest_side) {
  const bool as_texture = !is_processor(gpu) && longest_side <= gpu.limits().maxImageDimension3D;
  return as_texture ? Sampling::kTexture : Sampling::kGathering;
}

}  // namespace

CastMeans::CastMeans(const Gpu& gpu, std::optional<Sampling> wanted, std::uint32_t longest_side,
                     bool rays_by_shader)
    : sampling(wanted.value_or(suitable_sampling(gpu, longest_side))),
      band_samples(is_processor(gpu) ? kProcessorBand : kGpuBand),
      workers(sampling == Sampling::kGathering ? std::make_unique<RenderWorkers>() : nullptr),
      casts_here(is_processor(gpu) && workers && !rays_by_shader && ray_caster::is_fast()) {}

DeviceOptions live_device_options() {
  return {.own_light_device = !ray_caster::is_fast(), .in_background = true};
}

std::uint64_t CastMeans::private_band_samples() const {
  return band_samples / kPrivateBandDivisor;
}

Watchdog::Limits usual_limits(const Gpu& gpu) {
  Watchdog::Limits limits;
  if (is_processor(gpu) || gpu.candidate().kind == kStandInKind) limits.least_hung_ns = kProcessorHungNs;
  return limits;
}

}  // namespace fanlight
