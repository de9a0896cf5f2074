#pragma once

#include <span>

#include "proto/result.hpp"
#include "renderer/gpu_memory.hpp"

namespace fanlight {

/// The entries of an AngleTable on the GPU. Render thread only.
class AngleBuffer {
 public:
  AngleBuffer() = default;
  static Result<AngleBuffer> create(const Gpu& gpu, std::uint64_t bytes);

  /// Entries that the next record() brings to the GPU. Precondition: no upload is outstanding.
  void put(std::span<const float> entries);

  /// Records the upload where one is due.
  void record(VkCommandBuffer commands);

  const GpuBuffer& entries() const { return entries_; }

 private:
  GpuBuffer staged_;
  GpuBuffer entries_;
  bool due_ = false;
};

}  // namespace fanlight
