// SPDX-License-Identifier: Apache-2.0
// Defines functions of Vulkan in the program, or in a library that is loaded before the loader; see
// gpu_faults.hpp.
#include "tests/gpu/gpu_faults.hpp"

#include <dlfcn.h>

#include <array>
#include <chrono>
#include <condition_variable>
#include <limits>
#include <map>
#include <mutex>
#include <utility>
#include <vector>

namespace fanlight::test {
namespace {

enum class Health : std::uint8_t { kSound, kLost, kHung };

/// A copy of a submission that is made later.
struct Submission {
  VkQueue queue = VK_NULL_HANDLE;
  std::vector<VkSemaphoreSubmitInfo> waits;
  std::vector<VkCommandBufferSubmitInfo> commands;
  std::vector<VkSemaphoreSubmitInfo> signals;
};

struct Injector {
  std::mutex mutex;
  std::condition_variable cleared;
  std::condition_variable instance_gone;
  int instances = 0;
  std::array<GpuFault, static_cast<std::size_t>(GpuCall::kCalls)> faults;
  std::array<std::uint64_t, static_cast<std::size_t>(GpuCall::kCalls)> calls{};
  std::uint64_t happened = 0;
  std::uint64_t clears = 0;
  std::map<VkDevice, Health> devices;  // those that are not sound
  std::map<VkQueue, VkDevice> queues;
  std::vector<Submission> delayed;
  std::map<VkSemaphore, std::uint64_t> standing;  // values of counters that stand still

  Injector() {
    for (GpuFault& fault : faults) fault.times = 0;
  }
  GpuFault& fault_of(GpuCall call) { return faults[static_cast<std::size_t>(call)]; }
  Health health_of(VkDevice device) const {
    const auto found = devices.find(device);
    return found == devices.end() ? Health::kSound : found->second;
  }
};

Injector& injector() {
  // Never destroyed: detached threads may call until the very end.
  static auto* const made = new Injector();
  return *made;
}

template <typename Function>
Function next(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

/// Counts the call; the fault that concerns it, if one does. With the lock held.
std::optional<GpuFault> due(Injector& all, GpuCall call) {
  ++all.calls[static_cast<std::size_t>(call)];
  GpuFault& fault = all.fault_of(call);
  if (fault.times == 0) return {};
  if (fault.after > 0) {
    --fault.after;
    return {};
  }
  --fault.times;
  ++all.happened;
  return fault;
}

void lose(VkDevice device) {
  if (device == VK_NULL_HANDLE) return;
  static const auto wait_idle = next<PFN_vkDeviceWaitIdle>("vkDeviceWaitIdle");
  wait_idle(device);  // a lost device does no more work
  injector().devices[device] = Health::kLost;
}

void delay(VkQueue queue, std::uint32_t count, const VkSubmitInfo2* infos) {
  for (std::uint32_t index = 0; index < count; ++index) {
    const VkSubmitInfo2& info = infos[index];
    injector().delayed.push_back(
        {.queue = queue,
         .waits = {info.pWaitSemaphoreInfos, info.pWaitSemaphoreInfos + info.waitSemaphoreInfoCount},
         .commands = {info.pCommandBufferInfos, info.pCommandBufferInfos + info.commandBufferInfoCount},
         .signals = {info.pSignalSemaphoreInfos,
                     info.pSignalSemaphoreInfos + info.signalSemaphoreInfoCount}});
  }
}

void submit_delayed() {
  static const auto submit = next<PFN_vkQueueSubmit2>("vkQueueSubmit2");
  for (const Submission& each : std::exchange(injector().delayed, {})) {
    const VkSubmitInfo2 info{.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2,
                             .waitSemaphoreInfoCount = static_cast<std::uint32_t>(each.waits.size()),
                             .pWaitSemaphoreInfos = each.waits.data(),
                             .commandBufferInfoCount = static_cast<std::uint32_t>(each.commands.size()),
                             .pCommandBufferInfos = each.commands.data(),
                             .signalSemaphoreInfoCount = static_cast<std::uint32_t>(each.signals.size()),
                             .pSignalSemaphoreInfos = each.signals.data()};
    submit(each.queue, 1, &info, VK_NULL_HANDLE);
  }
}

}  // namespace

void inject(const GpuFault& fault) {
  const std::scoped_lock lock(injector().mutex);
  injector().fault_of(fault.call) = fault;
}

void clear_gpu_faults() {
  Injector& all = injector();
  const std::scoped_lock lock(all.mutex);
  for (GpuFault& fault : all.faults) fault.times = 0;
  std::erase_if(all.devices, [](const auto& device) { return device.second == Health::kHung; });
  submit_delayed();
  all.standing.clear();
  ++all.clears;
  all.cleared.notify_all();
}

std::uint64_t gpu_faults_so_far() {
  const std::scoped_lock lock(injector().mutex);
  return injector().happened;
}

std::uint64_t gpu_calls(GpuCall call) {
  const std::scoped_lock lock(injector().mutex);
  return injector().calls[static_cast<std::size_t>(call)];
}

bool wait_for_gpu_instances(int most) {
  Injector& all = injector();
  std::unique_lock lock(all.mutex);
  return all.instance_gone.wait_for(lock, std::chrono::minutes(1), [&] { return all.instances <= most; });
}

int gpu_instances() {
  const std::scoped_lock lock(injector().mutex);
  return injector().instances;
}

std::optional<VkResult> injected_result(VkDevice device, GpuCall call) {
  Injector& all = injector();
  const std::scoped_lock lock(all.mutex);
  if (all.health_of(device) == Health::kLost) return VK_ERROR_DEVICE_LOST;
  if (all.fault_of(call).stands) return {};
  const auto fault = due(all, call);
  if (!fault) return {};
  if (fault->result == VK_ERROR_DEVICE_LOST) lose(device);
  return fault->result;
}

}  // namespace fanlight::test

using fanlight::test::delay;
using fanlight::test::due;
using fanlight::test::GpuCall;
using fanlight::test::Health;
using fanlight::test::injected_result;
using fanlight::test::injector;
using fanlight::test::lose;
using fanlight::test::next;

extern "C" {

VKAPI_ATTR VkResult VKAPI_CALL vkCreateInstance(const VkInstanceCreateInfo* info,
                                                const VkAllocationCallbacks* callbacks,
                                                VkInstance* instance) {
  static const auto create = next<PFN_vkCreateInstance>("vkCreateInstance");
  const VkResult result = create(info, callbacks, instance);
  const std::scoped_lock lock(injector().mutex);
  if (result == VK_SUCCESS) ++injector().instances;
  return result;
}

VKAPI_ATTR void VKAPI_CALL vkDestroyInstance(VkInstance instance, const VkAllocationCallbacks* callbacks) {
  static const auto destroy = next<PFN_vkDestroyInstance>("vkDestroyInstance");
  destroy(instance, callbacks);
  if (instance == VK_NULL_HANDLE) return;
  const std::scoped_lock lock(injector().mutex);
  --injector().instances;
  injector().instance_gone.notify_all();
}

VKAPI_ATTR VkResult VKAPI_CALL vkCreateDevice(VkPhysicalDevice physical, const VkDeviceCreateInfo* info,
                                              const VkAllocationCallbacks* callbacks, VkDevice* device) {
  static const auto create = next<PFN_vkCreateDevice>("vkCreateDevice");
  if (const auto injected = injected_result(VK_NULL_HANDLE, GpuCall::kCreateDevice)) return *injected;
  const VkResult result = create(physical, info, callbacks, device);
  const std::scoped_lock lock(injector().mutex);
  if (result == VK_SUCCESS) injector().devices.erase(*device);  // a driver may use a handle again
  return result;
}

VKAPI_ATTR void VKAPI_CALL vkGetDeviceQueue(VkDevice device, std::uint32_t family, std::uint32_t index,
                                            VkQueue* queue) {
  static const auto get = next<PFN_vkGetDeviceQueue>("vkGetDeviceQueue");
  get(device, family, index, queue);
  const std::scoped_lock lock(injector().mutex);
  injector().queues[*queue] = device;
}

VKAPI_ATTR VkResult VKAPI_CALL vkQueueSubmit2(VkQueue queue, std::uint32_t count, const VkSubmitInfo2* infos,
                                              VkFence fence) {
  static const auto submit = next<PFN_vkQueueSubmit2>("vkQueueSubmit2");
  auto& all = injector();
  {
    std::unique_lock lock(all.mutex);
    const VkDevice device = all.queues[queue];
    const Health health = all.health_of(device);
    if (health == Health::kLost) return VK_ERROR_DEVICE_LOST;
    if (health == Health::kHung) return VK_SUCCESS;
    const auto fault = due(all, GpuCall::kSubmit);
    if (fault && fault->hangs) {
      all.devices[device] = Health::kHung;
      return VK_SUCCESS;
    }
    if (fault && fault->delayed) {
      delay(queue, count, infos);
      return VK_SUCCESS;
    }
    if (fault && fault->blocks) {
      const std::uint64_t before = all.clears;
      all.cleared.wait(lock, [&] { return all.clears != before; });
      return submit(queue, count, infos, fence);
    }
    if (fault && fault->result == VK_ERROR_DEVICE_LOST) lose(device);
    if (fault) return fault->result;
  }
  return submit(queue, count, infos, fence);
}

VKAPI_ATTR VkResult VKAPI_CALL vkGetSemaphoreCounterValue(VkDevice device, VkSemaphore semaphore,
                                                          std::uint64_t* value) {
  static const auto get = next<PFN_vkGetSemaphoreCounterValue>("vkGetSemaphoreCounterValue");
  if (const auto injected = injected_result(device, GpuCall::kSemaphoreValue)) {
    *value = std::numeric_limits<std::uint64_t>::max();
    return *injected;
  }
  const VkResult result = get(device, semaphore, value);
  auto& all = injector();
  const std::scoped_lock lock(all.mutex);
  if (result == VK_SUCCESS && all.fault_of(GpuCall::kSemaphoreValue).stands &&
      due(all, GpuCall::kSemaphoreValue))
    *value = all.standing.emplace(semaphore, *value).first->second;
  return result;
}

VKAPI_ATTR void VKAPI_CALL vkDestroySemaphore(VkDevice device, VkSemaphore semaphore,
                                              const VkAllocationCallbacks* callbacks) {
  static const auto destroy = next<PFN_vkDestroySemaphore>("vkDestroySemaphore");
  {
    const std::scoped_lock lock(injector().mutex);
    injector().standing.erase(semaphore);  // a driver may use a handle again
  }
  destroy(device, semaphore, callbacks);
}

VKAPI_ATTR VkResult VKAPI_CALL vkWaitSemaphores(VkDevice device, const VkSemaphoreWaitInfo* info,
                                                std::uint64_t timeout) {
  static const auto wait = next<PFN_vkWaitSemaphores>("vkWaitSemaphores");
  {
    const std::scoped_lock lock(injector().mutex);
    if (injector().health_of(device) == Health::kLost) return VK_ERROR_DEVICE_LOST;
  }
  return wait(device, info, timeout);
}

VKAPI_ATTR VkResult VKAPI_CALL vkDeviceWaitIdle(VkDevice device) {
  static const auto wait_idle = next<PFN_vkDeviceWaitIdle>("vkDeviceWaitIdle");
  auto& all = injector();
  {
    std::unique_lock lock(all.mutex);
    if (all.health_of(device) == Health::kLost) return VK_ERROR_DEVICE_LOST;
    all.cleared.wait(lock, [&] { return all.health_of(device) != Health::kHung; });
  }
  return wait_idle(device);
}

VKAPI_ATTR VkResult VKAPI_CALL vkCreateComputePipelines(VkDevice device, VkPipelineCache cache,
                                                        std::uint32_t count,
                                                        const VkComputePipelineCreateInfo* infos,
                                                        const VkAllocationCallbacks* callbacks,
                                                        VkPipeline* pipelines) {
  static const auto create = next<PFN_vkCreateComputePipelines>("vkCreateComputePipelines");
  if (const auto injected = injected_result(device, GpuCall::kBuildPipeline)) return *injected;
  return create(device, cache, count, infos, callbacks, pipelines);
}

VKAPI_ATTR VkResult VKAPI_CALL vkCreateCommandPool(VkDevice device, const VkCommandPoolCreateInfo* info,
                                                   const VkAllocationCallbacks* callbacks,
                                                   VkCommandPool* pool) {
  static const auto create = next<PFN_vkCreateCommandPool>("vkCreateCommandPool");
  if (const auto injected = injected_result(device, GpuCall::kCommandPool)) return *injected;
  return create(device, info, callbacks, pool);
}

}  // extern "C"
