// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "renderer/passes/pipelines.hpp"
#include "renderer/vulkan/device_handle.hpp"
#include "renderer/vulkan/gpu_memory.hpp"

namespace fanlight {

/// The buffers and textures of one view under the numbers of shaders/bindings.h, in two descriptor sets. The
/// sets differ only in FANLIGHT_BINDING_LIT and FANLIGHT_BINDING_DIFFUSED, which are swapped: each step of
/// pass 3's diffusion reads one and writes the other. Owns the descriptor pool; refers to the buffers. Render
/// thread only; nothing that uses the sets may be outstanding while they are written.
class DescriptorSets {
 public:
  enum class Order : std::uint8_t { kLitToDiffused, kDiffusedToLit };

  DescriptorSets() = default;
  static Result<DescriptorSets> create(const Gpu& gpu, const Pipelines& pipelines);

  void write(const Gpu& gpu, std::uint32_t binding, const GpuBuffer& buffer) const;
  void write(const Gpu& gpu, std::uint32_t binding, const GpuImage& image) const;

  void bind(VkCommandBuffer commands, const Pipelines& pipelines, Order order) const;

 private:
  DescriptorPoolHandle pool_;
  std::array<VkDescriptorSet, 2> sets_{};  // of the pool, by order
};

}  // namespace fanlight
