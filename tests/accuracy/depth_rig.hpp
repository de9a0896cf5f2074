// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>

#include "renderer/renderer.hpp"
#include "renderer/vulkan/gpu.hpp"
#include "tests/support/scanned_fan.hpp"

namespace fanlight::test {

class BareGpu;

/// The renderer as a function from a volume and a scene to depth maps. Throws std::runtime_error if the
/// renderer fails.
class DepthRig {
 public:
  DepthRig(BareGpu& gpu, const ScannedFan& fan, std::uint32_t frames, PictureSize size);

  /// Sets the volume of the next depth maps. It must exist until the next call of depths().
  void set_volume(const Volume& volume) { next_volume_ = &volume; }

  DepthMaps depths(Scene scene);

  /// The picture with the last depth maps.
  const Picture& picture() const { return picture_; }

  std::uint64_t pass1_runs() const { return counters_.pass1_runs.value(); }

 private:
  void run_until_shown();

  RenderCounters counters_;
  std::unique_ptr<Renderer> renderer_;
  const Volume* next_volume_ = nullptr;
  std::uint64_t revision_ = 0;
  Picture picture_;
};

/// The machine's GPU, without the slow validation layers. Throws std::runtime_error.
class BareGpu {
 public:
  explicit BareGpu(const std::string& name);
  const Gpu& gpu() const { return *gpu_; }
  /// Shared by all renderers on it.
  PipelineStore& pipelines() { return pipelines_; }

 private:
  std::unique_ptr<GpuInstance> instance_;
  std::unique_ptr<Gpu> gpu_;
  PipelineStore pipelines_;
};

}  // namespace fanlight::test
