#pragma once

#include <array>
#include <cstdint>

#include "renderer/device_handle.hpp"
#include "renderer/gpu_memory.hpp"
#include "renderer/passes.hpp"

namespace fanlight {

/// The buffers and textures of one slot under the numbers of shaders/bindings.h, in two sets that differ in
/// one thing: which of FANLIGHT_BINDING_LIT and FANLIGHT_BINDING_DIFFUSED a step of pass 3's diffusion reads
/// and which it writes. Render thread only; nothing that uses the sets may be outstanding while they are
/// written.
class DescriptorSets {
 public:
  enum class Order : std::uint8_t { kLitToDiffused, kDiffusedToLit };

  DescriptorSets() = default;
  static Result<DescriptorSets> create(const Gpu& gpu, const Passes& passes);

  void write(const Gpu& gpu, std::uint32_t binding, const GpuBuffer& buffer) const;
  void write(const Gpu& gpu, std::uint32_t binding, const GpuImage& image) const;

  void bind(VkCommandBuffer commands, const Passes& passes, Order order) const;

 private:
  DescriptorPoolHandle pool_;
  std::array<VkDescriptorSet, 2> sets_{};  // the pool's, by order
};

}  // namespace fanlight
