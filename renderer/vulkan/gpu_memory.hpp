// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "renderer/vulkan/device_handle.hpp"
#include "renderer/vulkan/gpu.hpp"

namespace fanlight {

/// Memory that a buffer is allocated in.
enum class BufferPlace : std::uint8_t {
  kDevice,   ///< the GPU's own memory
  kToGpu,    ///< mapped: written by the processor, read by the GPU
  kFromGpu,  ///< mapped, cached where possible: written by the GPU, read by the processor
};

/// A buffer with its own memory allocation, mapped for its whole life unless it is in BufferPlace::kDevice.
class GpuBuffer {
 public:
  GpuBuffer() = default;
  /// `name` appears in debugging tools. With a format, shaders may read and write the buffer as texels of
  /// that format. Error: kUnavailable where the GPU has no memory for it.
  static Result<GpuBuffer> create(const Gpu& gpu, const char* name, std::uint64_t bytes,
                                  VkBufferUsageFlags usage, BufferPlace place,
                                  VkFormat texels = VK_FORMAT_UNDEFINED);

  VkBuffer get() const { return buffer_.get(); }
  VkBufferView texels() const { return view_.get(); }
  std::uint64_t bytes() const { return bytes_; }

  /// The mapped bytes; empty for BufferPlace::kDevice. Coherent: no flush is needed.
  std::span<std::uint8_t> mapped() const { return {mapped_, mapped_ == nullptr ? 0 : bytes_}; }

  template <typename T>
  T& mapped_as() const {
    return *reinterpret_cast<T*>(mapped_);
  }

 private:
  MemoryHandle memory_;
  BufferHandle buffer_;  // after the memory it is bound to, so that it is destroyed first
  BufferViewHandle view_;
  std::uint64_t bytes_ = 0;
  std::uint8_t* mapped_ = nullptr;
};

/// A row of create_buffers(); as the arguments of GpuBuffer::create().
struct WantedBuffer {
  const char* name = "";
  GpuBuffer* buffer = nullptr;
  std::uint64_t bytes = 0;
  VkBufferUsageFlags usage = 0;
  BufferPlace place = BufferPlace::kDevice;
};
/// Creates all of them. Error: as GpuBuffer::create(), of the first that failed.
Result<void> create_buffers(const Gpu& gpu, std::span<const WantedBuffer> wanted);

/// A sampled image in the GPU's own memory, filled by copies: 3D, or 2D where its depth is 1, or 1D where its
/// depth and height are 1.
class GpuImage {
 public:
  GpuImage() = default;
  static Result<GpuImage> create(const Gpu& gpu, const char* name, VkFormat format, VkExtent3D extent);

  VkImage get() const { return image_.get(); }
  VkImageView view() const { return view_.get(); }
  VkExtent3D extent() const { return extent_; }

 private:
  MemoryHandle memory_;
  ImageHandle image_;
  ImageViewHandle view_;
  VkExtent3D extent_{};
};

}  // namespace fanlight
