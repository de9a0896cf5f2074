#pragma once

#include <cstdint>
#include <span>

#include "renderer/device_handle.hpp"
#include "renderer/gpu.hpp"

namespace fanlight {

/// Where a buffer lives.
enum class BufferPlace : std::uint8_t {
  kDevice,   ///< the GPU's own memory
  kToGpu,    ///< mapped: written by the processor, read by the GPU
  kFromGpu,  ///< mapped, cached where there is such memory: written by the GPU, read by the processor
};

/// A buffer with memory of its own, mapped for its whole life where the place says so.
class GpuBuffer {
 public:
  GpuBuffer() = default;
  /// With a format, shaders may read and write it as texels of that.
  static Result<GpuBuffer> create(const Gpu& gpu, std::uint64_t bytes, VkBufferUsageFlags usage,
                                  BufferPlace place, VkFormat texels = VK_FORMAT_UNDEFINED);

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
  BufferHandle buffer_;  // after the memory it is bound to, so that it goes first
  BufferViewHandle view_;
  std::uint64_t bytes_ = 0;
  std::uint8_t* mapped_ = nullptr;
};

/// A sampled 3D image, 2D where its depth is 1, 1D where its height is too, in the GPU's own memory, filled
/// by copies.
class GpuImage {
 public:
  GpuImage() = default;
  static Result<GpuImage> create(const Gpu& gpu, VkFormat format, VkExtent3D extent);

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
