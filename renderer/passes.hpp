#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <utility>

#include "proto/scene.hpp"
#include "renderer/device_handle.hpp"
#include "renderer/gpu.hpp"
#include "renderer/view.hpp"

namespace fanlight {

/// The compute pipelines of passes 1 to 3 and the one descriptor set layout that they share
/// (shaders/bindings.h). Render thread only.
class Passes {
 public:
  static Result<std::unique_ptr<Passes>> create(const Gpu& gpu);

  VkDescriptorSetLayout set_layout() const { return set_layout_.get(); }
  VkPipelineLayout layout() const { return layout_.get(); }

  /// Pass 1 for a detector window and a mode. Built when first asked for, and kept.
  Result<VkPipeline> cast(int window, Mode mode);

  /// Pass 2: the moving average's two halves, then light; pass 3.
  VkPipeline filter_rows() const { return filter_rows_.get(); }
  VkPipeline filter_columns() const { return filter_columns_.get(); }
  VkPipeline light() const { return light_.get(); }
  VkPipeline finish() const { return finish_.get(); }

 private:
  explicit Passes(const Gpu& gpu) : gpu_(gpu) {}
  Result<void> create_layouts();
  Result<PipelineHandle> pipeline(std::span<const std::uint32_t> spirv,
                                  const VkSpecializationInfo* constants);

  const Gpu& gpu_;
  SamplerHandle sampler_;  // part of the set layout for as long as that lives
  DescriptorSetLayoutHandle set_layout_;
  PipelineLayoutHandle layout_;
  std::map<std::pair<int, Mode>, PipelineHandle> cast_;
  PipelineHandle filter_rows_;
  PipelineHandle filter_columns_;
  PipelineHandle light_;
  PipelineHandle finish_;
};

}  // namespace fanlight
