// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vulkan/vulkan.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "proto/base/counter.hpp"
#include "proto/base/result.hpp"
#include "renderer/vulkan/buffer_access.hpp"

namespace fanlight {

/// The kind of a candidate that renders on the processor (lavapipe).
inline constexpr std::string_view kProcessorKind = "processor";
/// The kind of such a candidate where it stands in for a GPU.
inline constexpr std::string_view kStandInKind = "processor in place of a GPU";

/// A GPU of this machine, and why it cannot be used.
struct GpuCandidate {
  VkPhysicalDevice physical = VK_NULL_HANDLE;
  std::string name;
  std::string kind;    ///< "discrete GPU", "processor", ...
  std::string driver;  ///< name and version
  std::uint32_t queue_family = 0;
  std::uint32_t queues = 0;           ///< of that family
  std::vector<std::string> refusals;  ///< one clause each; empty where it can be used
};

/// The Vulkan instance: finds the machine's GPUs. Any thread, one at a time.
class GpuInstance {
 public:
  struct Config {
    /// Loads the Khronos validation layer with its synchronisation checks, and counts its messages.
    bool validation = false;
    /// Counts the messages of several instances; must outlive them. Null: each counts its own.
    Counter* messages = nullptr;
    /// A driver on the processor counts as a GPU (kStandInKind), so that shaders run every pass. For tests of
    /// what runs on GPUs.
    bool processor_as_gpu = false;
  };
  /// Errors: kNotFound where no Vulkan driver, or no validation layer, is installed.
  static Result<std::unique_ptr<GpuInstance>> create(const Config& config);
  ~GpuInstance();
  GpuInstance(const GpuInstance&) = delete;
  GpuInstance& operator=(const GpuInstance&) = delete;

  /// Every GPU, best first: usable ones before refused ones, then GPUs before the processor.
  const std::vector<GpuCandidate>& candidates() const { return candidates_; }

  /// The best usable one whose name contains `name`, in any case; null: none.
  const GpuCandidate* candidate(std::string_view name) const;

  /// Warnings and errors of the validation layer so far; 0 without it, and with Config::messages. Each is
  /// printed to stderr.
  std::uint64_t validation_messages() const { return validation_messages_.value(); }

  /// Whether objects can be named (VK_EXT_debug_utils).
  bool has_debug_utils() const { return has_debug_utils_; }

  /// The instance is never destroyed: a device of it cannot be.
  void keep() const { kept_ = true; }

 private:
  GpuInstance() = default;
  Result<void> create_instance(const Config& config);
  Result<void> find_candidates(const Config& config);

  VkInstance instance_ = VK_NULL_HANDLE;
  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
  bool has_debug_utils_ = false;
  mutable bool kept_ = false;
  Counter validation_messages_;
  std::vector<GpuCandidate> candidates_;
};

/// The logical device of one GPU and its queues. One thread uses the queues, and notes and reads the fault:
/// the render thread, or the caller where a command renders without one.
class Gpu {
 public:
  /// Whether the device works.
  enum class Condition : std::uint8_t {
    kSound,
    kLost,  ///< it does no more work; its objects can be destroyed
    kHung,  ///< it does not finish its work; its objects cannot be destroyed as long as it uses them
  };

  /// `access`: how shaders read buffers; without it storage buffers where texel buffers are small, on a
  /// processor what try_buffer_access() finds faster, and else texel buffers.
  ///
  /// The best usable candidate, or the best one whose name contains `name` (any case). The instance must
  /// outlive the result. The destructor leaves a device that hangs, and its instance, to the end of the
  /// process. Error: kNotFound; it names every GPU found and why it was refused.
  static Result<std::unique_ptr<Gpu>> create(const GpuInstance& instance, std::string_view name,
                                             std::optional<BufferAccess> access = std::nullopt);
  ~Gpu();
  Gpu(const Gpu&) = delete;
  Gpu& operator=(const Gpu&) = delete;

  VkDevice device() const { return device_; }
  const GpuCandidate& candidate() const { return candidate_; }
  const VkPhysicalDeviceProperties& properties() const { return properties_; }
  const VkPhysicalDeviceLimits& limits() const { return properties_.limits; }
  BufferAccess buffer_access() const { return buffer_access_; }
  std::uint64_t largest_buffer_bytes() const { return largest_buffer_bytes_; }
  std::uint64_t largest_allocation_bytes() const { return largest_allocation_bytes_; }

  /// Passes 0 and 1 and uploads go to the cast queue, passes 2 and 3 to the light queue. Both are the same
  /// queue where the family has only one.
  VkQueue cast_queue() const { return cast_queue_; }
  VkQueue light_queue() const { return light_queue_; }

  /// Index of a memory type among `type_bits` that has `wanted`, preferring one that also has `preferred`.
  /// Error: kUnavailable where there is none.
  Result<std::uint32_t> memory_type(std::uint32_t type_bits, VkMemoryPropertyFlags wanted,
                                    VkMemoryPropertyFlags preferred) const;
  /// Size of the heap of a memory type.
  std::uint64_t heap_bytes(std::uint32_t memory_type) const {
    return memory_.memoryHeaps[memory_.memoryTypes[memory_type].heapIndex].size;
  }

  /// See renderer/vulkan/debug_name.hpp.
  void set_debug_name(VkObjectType type, std::uint64_t handle, const char* name) const;

  /// Notes that the device is of no more use. The first fault counts: later errors follow from it. Whatever
  /// the device wrote after a fault is not to be shown.
  void note_fault(Condition condition, const Error& error) const;
  /// The error that was noted; nullptr: none.
  const Error* fault() const { return fault_ ? &*fault_ : nullptr; }
  Condition condition() const { return condition_; }

  /// Blocks until the device has finished all work, for ever where it hangs: for a thread that no one waits
  /// for. Afterwards the device counts as lost, and its objects can be destroyed.
  void wait_for_end() const;

 private:
  Result<void> choose_buffer_access(std::optional<BufferAccess> access);
  explicit Gpu(const GpuInstance& instance) : instance_(instance) {}

  const GpuInstance& instance_;
  GpuCandidate candidate_;
  VkPhysicalDeviceProperties properties_{};
  std::uint64_t largest_buffer_bytes_ = 0;
  std::uint64_t largest_allocation_bytes_ = 0;
  BufferAccess buffer_access_ = BufferAccess::kTexels;
  VkPhysicalDeviceMemoryProperties memory_{};
  VkDevice device_ = VK_NULL_HANDLE;
  PFN_vkSetDebugUtilsObjectNameEXT name_object_ = nullptr;  // null without VK_EXT_debug_utils
  VkQueue cast_queue_ = VK_NULL_HANDLE;
  VkQueue light_queue_ = VK_NULL_HANDLE;
  mutable Condition condition_ = Condition::kSound;
  mutable std::optional<Error> fault_;
};

}  // namespace fanlight
