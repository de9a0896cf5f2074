// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "proto/base/result.hpp"
#include "renderer/vulkan/gpu_memory.hpp"

namespace fanlight {

/// The entries of an AngleTable on the GPU, each with the next one: a shader fetches both at once. Owns the
/// buffer that shaders read, and a staging buffer where that one is the GPU's own. Render thread only.
class AngleBuffer {
 public:
  AngleBuffer() = default;
  /// `place`: of what shaders read: kDevice, or kToGpu, which needs no upload. Error: no memory on the GPU.
  static Result<AngleBuffer> create(const Gpu& gpu, std::uint64_t entries_at_most, BufferPlace place);

  /// Stages entries that the next record() uploads. Precondition: no upload is outstanding, and nothing that
  /// reads the entries.
  void put(std::span<const float> entries);

  /// Records the upload, if entries were staged since the last one.
  void record(VkCommandBuffer commands);

  const GpuBuffer& entries() const { return entries_; }

 private:
  GpuBuffer staged_;
  GpuBuffer entries_;
  bool is_staged_ = true;
  bool due_ = false;
};

}  // namespace fanlight
