// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vulkan/vulkan.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "proto/model/picture.hpp"
#include "renderer/passes/pixel_rect.hpp"
#include "renderer/pipelines/descriptor_sets.hpp"
#include "renderer/shading/surface_shading.hpp"

namespace fanlight {

/// One step of passes 2 and 3: a dispatch, or work of the processor. Each waits for the one before it.
struct LightStep {
  VkPipeline pipeline = VK_NULL_HANDLE;
  std::optional<shading::Step> here;  ///< where the processor runs it: instead of a pipeline,
  PixelRect part;                     ///< in this part of the picture, or of the map of soft light
  std::uint32_t groups_across = 0;
  std::uint32_t groups_down = 1;
  std::uint32_t first_across = 0;  ///< the number of the first group
  std::uint32_t first_down = 0;
  Stage stage = Stage::kFilter;  ///< kFilter, kLight or kFinish
  DescriptorSets::Order order = DescriptorSets::Order::kLitToDiffused;
};

/// The dispatches of passes 2 and 3 of one picture, in order, and how many of them were submitted. Neither
/// allocates nor knows a GPU.
class LightSteps {
 public:
  static constexpr std::size_t kMostFilterSteps = 13;
  static constexpr std::size_t kMostLightSteps = 4;
  static constexpr std::size_t kMostDiffusionSteps = 30;  // of finish.iterations

  /// The descriptor set after that many steps of pass 3: each reads the picture that the one before wrote.
  static DescriptorSets::Order order_after(int steps) {
    using Order = DescriptorSets::Order;
    return steps % 2 == 0 ? Order::kLitToDiffused : Order::kDiffusedToLit;
  }

  void clear() { count_ = next_ = 0; }
  void add(const LightStep& step) { steps_.at(count_++) = step; }
  /// Drops the steps of this stage and those after them. Precondition: none of them was submitted.
  void drop_from(Stage stage) { count_ = index_of(stage); }

  const LightStep& operator[](std::size_t index) const { return steps_.at(index); }
  std::size_t count() const { return count_; }
  std::size_t next() const { return next_; }
  bool submitted() const { return next_ == count_; }
  /// Whether a step of this stage, or of one after it, was submitted.
  bool begun(Stage stage) const { return next_ > index_of(stage); }
  void submit_until(std::size_t end) { next_ = end; }

  /// Steps of one stage.
  std::size_t count_of(Stage stage) const;

  /// The index past the last step of the next piece: at least one step, all of one stage, and together at
  /// most most_ms where each step of the stage takes step_ms. Precondition: not submitted().
  std::size_t end_of_piece(double step_ms, double most_ms) const;

 private:
  std::size_t index_of(Stage stage) const;

  // Filter, light, outline, diffusion, finish.
  std::array<LightStep, kMostFilterSteps + kMostLightSteps + kMostDiffusionSteps + 2> steps_{};
  std::size_t count_ = 0;
  std::size_t next_ = 0;
};

}  // namespace fanlight
