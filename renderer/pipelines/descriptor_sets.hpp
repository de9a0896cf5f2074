// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "renderer/pipelines/pipelines.hpp"
#include "renderer/vulkan/device_handle.hpp"
#include "renderer/vulkan/gpu_memory.hpp"

namespace fanlight {

/// The buffers and textures of one pass under the numbers of shaders/bindings.h, in two descriptor sets. The
/// sets differ only in FANLIGHT_BINDING_LIT and FANLIGHT_BINDING_DIFFUSED, which are swapped: each step of
/// pass 3's diffusion reads one and writes the other. Owns the descriptor pool; refers to the buffers. Render
/// thread only; nothing that uses the sets may be outstanding while they are written.
///
/// A binding that was not written names a placeholder, since lavapipe reads all descriptors of a set, also
/// those that the shader does not use.
class DescriptorSets {
 public:
  enum class Order : std::uint8_t { kLitToDiffused, kDiffusedToLit };

  DescriptorSets() = default;
  /// Error: no memory on the GPU.
  static Result<DescriptorSets> create(const PassDevice& device);

  /// A buffer or an image without memory: the placeholder.
  void write(std::uint32_t binding, const GpuBuffer& buffer) const;
  void write(std::uint32_t binding, const GpuImage& image) const;

  void bind(VkCommandBuffer commands, Order order) const;

 private:
  Result<void> create_sets();
  Result<void> create_placeholders();

  PassDevice device_;
  GpuBuffer no_buffer_;
  GpuImage no_image_;
  DescriptorPoolHandle pool_;
  std::array<VkDescriptorSet, 2> sets_{};  // of the pool, by order
};

}  // namespace fanlight
