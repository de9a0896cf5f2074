#pragma once

#include <cstdint>
#include <memory>

#include "renderer/gpu.hpp"
#include "renderer/renderer.hpp"
#include "tests/support/scanned_fan.hpp"

namespace fanlight::test {

/// The renderer as a function from a volume and a scene to depth maps. Throws std::runtime_error where the
/// renderer fails.
class DepthRig {
 public:
  DepthRig(const Gpu& gpu, const ScannedFan& fan, std::uint32_t frames, PictureSize size);

  /// The volume that the next depth maps are of; it must stay until then.
  void look_at(const Volume& volume) { next_volume_ = &volume; }

  DepthMaps depths(Scene scene);

  std::uint64_t pass1_runs() const { return counters_.pass1_runs.value(); }

 private:
  void run_until_shown();

  RenderCounters counters_;
  std::unique_ptr<Renderer> renderer_;
  const Volume* next_volume_ = nullptr;
  std::uint64_t revision_ = 0;
};

/// The machine's GPU, without the validation layers, which cost time. Throws as above.
class BareGpu {
 public:
  explicit BareGpu(const std::string& name);
  const Gpu& gpu() const { return *gpu_; }

 private:
  std::unique_ptr<GpuInstance> instance_;
  std::unique_ptr<Gpu> gpu_;
};

}  // namespace fanlight::test
