// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vulkan/vulkan.h>

#include <cstdint>
#include <optional>

namespace fanlight::test {

/// Calls of Vulkan that can be made to fail. The program's calls go through definitions of these functions in
/// gpu_faults.cpp (and memory_census.cpp), which stand before the loader and its layers.
enum class GpuCall : std::uint8_t {
  kSubmit,          ///< vkQueueSubmit2
  kSemaphoreValue,  ///< vkGetSemaphoreCounterValue
  kAllocateMemory,
  kBuildPipeline,  ///< vkCreateComputePipelines
  kCommandPool,    ///< vkCreateCommandPool
  kCreateDevice,
  kCalls
};

/// What happens to some calls.
struct GpuFault {
  GpuCall call = GpuCall::kSubmit;
  std::uint64_t after = 0;  ///< calls that pass before
  std::uint64_t times = 1;  ///< calls that are concerned then
  /// The call is not made and returns this. With VK_ERROR_DEVICE_LOST the device finishes its work and is
  /// lost: its later calls return the same. A counter is then read as the largest number, which a driver may
  /// return too.
  VkResult result = VK_ERROR_DEVICE_LOST;
  /// kSubmit: it succeeds, and neither it nor what follows on that device is ever executed; waiting for the
  /// device to be idle blocks until clear_gpu_faults().
  bool hangs = false;
  /// kSubmit: it succeeds, and is executed at clear_gpu_faults().
  bool delayed = false;
  /// kSemaphoreValue: the counter of each device stands still from now on, whatever the device finishes.
  bool stands = false;
  /// kSubmit: it does not return before clear_gpu_faults(), and is made then.
  bool blocks = false;
};

/// Replaces the fault of that call, and counts from now. Any thread, as the functions below.
void inject(const GpuFault& fault);

/// Removes all faults. Lost devices stay lost.
void clear_gpu_faults();

/// How many calls the faults have concerned so far.
std::uint64_t gpu_faults_so_far();

/// Calls so far, with those that failed.
std::uint64_t gpu_calls(GpuCall call);

/// Blocks until the program has this many instances of Vulkan or fewer, for a minute at most. Whether it has.
bool wait_for_gpu_instances(int most);

/// Instances of Vulkan that were created and not destroyed.
int gpu_instances();

/// For a definition of such a function: what it returns instead of the call; absent: it makes the call.
std::optional<VkResult> injected_result(VkDevice device, GpuCall call);

}  // namespace fanlight::test
