// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "renderer/parameters/light_parameters.hpp"
#include "renderer/parameters/view_frame.hpp"
#include "renderer/passes/light_memory.hpp"
#include "renderer/passes/light_steps.hpp"
#include "renderer/shading/surface_shading.hpp"
#include "renderer/volume/render_workers.hpp"
#include "renderer/vulkan/gpu_timestamps.hpp"

namespace fanlight {

/// Runs the steps of a LightPass after the filter on the processor, where the pass's memory is the
/// processor's. Render thread only.
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

  /// Runs the steps from `begin` to before `end`, none of them of the filter. `colours`: of pass 1.
  /// Precondition: the GPU has written what they read.
  void run(const LightSteps& steps, std::size_t begin, std::size_t end, const LightMemory& memory,
           const std::uint32_t* colours, PictureSize size);

  /// Copies what else a picture consists of to where it is read. `colours`: of pass 1; null: they are read
  /// where they are.
  void read_back(const LightMemory& memory, const std::uint32_t* colours, PictureSize size);

  /// When each stage ran since begin(); 0 for the others.
  const std::array<StageSpan, kStages>& spans() const { return spans_; }
  /// How long the steps of each stage took; 0 for the others.
  const std::array<double, kStages>& ms() const { return ms_; }

 private:
  void note(Stage stage, std::int64_t began_ns);

  RenderWorkers* workers_ = nullptr;
  shading::Method method_;
  std::array<StageSpan, kStages> spans_{};
  std::array<double, kStages> ms_{};
};

}  // namespace fanlight
