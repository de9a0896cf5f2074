// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "proto/base/result.hpp"
#include "renderer/vulkan/gpu_memory.hpp"

namespace fanlight {

/// The entries of an AngleTable on the GPU, each with the next one: a shader fetches both at once. Owns the
/// staging buffer and the buffer that shaders read. Render thread only.
class AngleBuffer {
 public:
  AngleBuffer() = default;
  static Result<AngleBuffer> create(const Gpu& gpu, std::uint64_t entries_at_most);

  /// Stages entries that the next record() uploads. Precondition: no upload is outstanding.
  void put(std::span<const float> entries);

  /// Records the upload, if entries were staged since the last one.
  void record(VkCommandBuffer commands);

  const GpuBuffer& entries() const { return entries_; }

 private:
  GpuBuffer staged_;
  GpuBuffer entries_;
  bool due_ = false;
};

}  // namespace fanlight
