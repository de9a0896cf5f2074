#pragma once

#include <vulkan/vulkan.h>

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "proto/counter.hpp"
#include "proto/result.hpp"

namespace fanlight {

/// The kind of a candidate that renders on the processor (lavapipe).
inline constexpr std::string_view kProcessorKind = "processor";

/// A GPU of this machine, and why it would not serve.
struct GpuCandidate {
  VkPhysicalDevice physical = VK_NULL_HANDLE;
  std::string name;
  std::string kind;    ///< "discrete GPU", "processor", ...
  std::string driver;  ///< name and version
  std::uint32_t queue_family = 0;
  std::uint32_t queues = 0;           ///< of that family
  std::vector<std::string> refusals;  ///< a clause each; empty where it serves
};

/// The Vulkan instance: finds the machine's GPUs. Any thread, one at a time.
class GpuInstance {
 public:
  struct Config {
    /// Loads the Khronos validation layer, with its synchronisation checks, and counts what it says.
    bool validation = false;
  };
  static Result<std::unique_ptr<GpuInstance>> create(const Config& config);
  ~GpuInstance();
  GpuInstance(const GpuInstance&) = delete;
  GpuInstance& operator=(const GpuInstance&) = delete;

  /// Every GPU, best first: those that serve before those that do not, then real ones before the processor.
  const std::vector<GpuCandidate>& candidates() const { return candidates_; }

  /// Warnings and errors of the validation layer so far; 0 without it. Each is printed to stderr.
  std::uint64_t validation_messages() const { return validation_messages_.value(); }

 private:
  GpuInstance() = default;
  Result<void> find_candidates();

  VkInstance instance_ = VK_NULL_HANDLE;
  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
  Counter validation_messages_;
  std::vector<GpuCandidate> candidates_;
};

/// The logical device of one GPU and its queues. The queues belong to the thread that renders.
class Gpu {
 public:
  /// The best candidate that serves, or the best whose name contains `name` (any case). The instance must
  /// outlive it. The error names every GPU found and why it was refused.
  static Result<std::unique_ptr<Gpu>> create(const GpuInstance& instance, std::string_view name);
  ~Gpu();
  Gpu(const Gpu&) = delete;
  Gpu& operator=(const Gpu&) = delete;

  VkDevice device() const { return device_; }
  const GpuCandidate& candidate() const { return candidate_; }
  const VkPhysicalDeviceLimits& limits() const { return limits_; }
  std::uint64_t largest_buffer_bytes() const { return largest_buffer_bytes_; }

  /// Pass 1 and uploads go to one, passes 2 and 3 to the other; the same where the family has only one.
  VkQueue cast_queue() const { return cast_queue_; }
  VkQueue light_queue() const { return light_queue_; }

  /// Index of a memory type among `type_bits` that has `wanted`, preferring one that also has `preferred`.
  Result<std::uint32_t> memory_type(std::uint32_t type_bits, VkMemoryPropertyFlags wanted,
                                    VkMemoryPropertyFlags preferred) const;
  /// All memory that there is of a type.
  std::uint64_t heap_bytes(std::uint32_t memory_type) const {
    return memory_.memoryHeaps[memory_.memoryTypes[memory_type].heapIndex].size;
  }

 private:
  Gpu() = default;

  GpuCandidate candidate_;
  VkPhysicalDeviceLimits limits_{};
  std::uint64_t largest_buffer_bytes_ = 0;
  VkPhysicalDeviceMemoryProperties memory_{};
  VkDevice device_ = VK_NULL_HANDLE;
  VkQueue cast_queue_ = VK_NULL_HANDLE;
  VkQueue light_queue_ = VK_NULL_HANDLE;
};

}  // namespace fanlight
