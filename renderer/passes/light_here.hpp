// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "renderer/parameters/light_parameters.hpp"
#include "renderer/parameters/view_frame.hpp"
#include "renderer/passes/cast_maps.hpp"
#include "renderer/passes/light_memory.hpp"
#include "renderer/passes/light_regions.hpp"
#include "renderer/passes/light_steps.hpp"
#include "renderer/shading/surface_shading.hpp"
#include "renderer/volume/render_workers.hpp"
#include "renderer/vulkan/gpu_timestamps.hpp"

namespace fanlight {

/// Runs steps of a LightPass on the processor, where the pass's memory is the processor's. Render thread
/// only.
class LightHere {
 public:
  LightHere() = default;
  /// `workers`: null: the GPU runs all steps.
  explicit LightHere(RenderWorkers* workers) : workers_(workers) {}

  bool on() const { return workers_ != nullptr; }

  /// Of the picture that begins.
  void begin(const LightKeys& keys);
  /// Sets how a changed light is computed, and keeps the times.
  void change(const LightKeys& keys);

  /// Sets the maps of pass 1, which must stay where they are.
  void read(const CastMaps& maps);

  // Adds a step, or the steps after the temporal filter, or those of the light and pass 3, as the GPU has
  // them.
  struct LightOptions {
    PictureSize size;
    bool outlines = false;
    int diffusion_steps = 0;
  };
  static void add_step(LightSteps& steps, shading::Step step, const PixelRect& part, PictureSize size);
  static void add_filter_steps(LightSteps& steps, const LightKeys& keys, const LightRegions& parts,
                               PictureSize size);
  static void add_light_steps(LightSteps& steps, const LightKeys& keys, const LightRegions& parts,
                              const LightOptions& options);

  /// Runs the steps from `begin` to before `end`. Precondition: the GPU has written what they read.
  void run(const LightSteps& steps, std::size_t begin, std::size_t end, const LightMemory& memory);

  /// Copies what else a picture consists of to where it is read. `colours`: those of pass 1 too.
  void read_back(const LightMemory& memory, PictureSize size, bool colours);

  /// When each stage ran since begin(); 0 for the others.
  const std::array<StageSpan, kStages>& spans() const { return spans_; }
  /// How long the steps of each stage took; 0 for the others.
  const std::array<double, kStages>& ms() const { return ms_; }

 private:
  shading::Memory memory_of(const LightStep& step, const LightMemory& memory) const;
  void note(Stage stage, std::int64_t began_ns);

  RenderWorkers* workers_ = nullptr;
  shading::Method method_;
  // Of pass 1.
  const float* depth_ = nullptr;
  const float* confidence_ = nullptr;
  const std::uint32_t* colour_ = nullptr;
  std::array<StageSpan, kStages> spans_{};
  std::array<double, kStages> ms_{};
};

}  // namespace fanlight
