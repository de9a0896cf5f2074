// SPDX-License-Identifier: Apache-2.0
#include "renderer/vulkan/gpu.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "renderer/vulkan/access_trial.hpp"
#include "renderer/vulkan/debug_name.hpp"
#include "renderer/vulkan/shader_interface.hpp"
#include "renderer/vulkan/vulkan_result.hpp"

namespace fanlight {

namespace {

Error none_serves(const std::vector<GpuCandidate>& candidates, std::string_view name) {
  std::string message = name.empty() ? "no GPU serves, expected one with Vulkan 1.3 compute"
                                     : fmt::format("no GPU whose name contains \"{}\" serves", name);
  if (candidates.empty()) message += "; none was found";
  for (const GpuCandidate& candidate : candidates) {
    message +=
        fmt::format("; {}: {}", candidate.name,
                    candidate.refusals.empty() ? "it would serve"
                                               : fmt::format("{}", fmt::join(candidate.refusals, ", ")));
  }
  return {ErrorCode::kNotFound, message};
}

}  // namespace

Result<std::unique_ptr<Gpu>> Gpu::create(const GpuInstance& instance, std::string_view name,
                                         std::optional<BufferAccess> access) {
  const GpuCandidate* const chosen = instance.candidate(name);
  if (chosen == nullptr) return none_serves(instance.candidates(), name);

  std::unique_ptr<Gpu> made(new Gpu(instance));
  made->candidate_ = *chosen;
  VkPhysicalDeviceVulkan11Properties properties11{
      .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_PROPERTIES};
  VkPhysicalDeviceVulkan13Properties properties13{
      .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_PROPERTIES, .pNext = &properties11};
  VkPhysicalDeviceProperties2 properties{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2,
                                         .pNext = &properties13};
  vkGetPhysicalDeviceProperties2(chosen->physical, &properties);
  made->properties_ = properties.properties;
  made->largest_buffer_bytes_ = properties13.maxBufferSize;
  made->largest_allocation_bytes_ = properties11.maxMemoryAllocationSize;
  vkGetPhysicalDeviceMemoryProperties(chosen->physical, &made->memory_);

  constexpr std::array kPriorities = {0.5F, 1.0F};  // a changed light goes before a new volume
  const VkDeviceQueueCreateInfo queues{.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                       .queueFamilyIndex = chosen->queue_family,
                                       .queueCount = std::min(chosen->queues, 2U),
                                       .pQueuePriorities = kPriorities.data()};
  VkPhysicalDeviceVulkan13Features features13{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES,
                                              .synchronization2 = VK_TRUE,
                                              .maintenance4 = VK_TRUE};  // work group sizes of SPIR-V 1.6
  VkPhysicalDeviceVulkan12Features features12{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES,
                                              .pNext = &features13,
                                              .scalarBlockLayout = VK_TRUE,
                                              .hostQueryReset = VK_TRUE,
                                              .timelineSemaphore = VK_TRUE};
  const VkDeviceCreateInfo info{.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                .pNext = &features12,
                                .queueCreateInfoCount = 1,
                                .pQueueCreateInfos = &queues};
  const VkResult result = vkCreateDevice(chosen->physical, &info, nullptr, &made->device_);
  if (result != VK_SUCCESS) return vulkan_error("vkCreateDevice", result);
  vkGetDeviceQueue(made->device_, chosen->queue_family, 0, &made->cast_queue_);
  vkGetDeviceQueue(made->device_, chosen->queue_family, queues.queueCount - 1, &made->light_queue_);
  if (instance.has_debug_utils()) {
    made->name_object_ = reinterpret_cast<PFN_vkSetDebugUtilsObjectNameEXT>(
        vkGetDeviceProcAddr(made->device_, "vkSetDebugUtilsObjectNameEXT"));
  }
  const bool one_queue = made->cast_queue_ == made->light_queue_;
  fanlight::set_debug_name(*made, made->cast_queue_, one_queue ? "cast and light queue" : "cast queue");
  if (!one_queue) fanlight::set_debug_name(*made, made->light_queue_, "light queue");
  if (auto access_chosen = made->choose_buffer_access(access); !access_chosen) return access_chosen.error();
  return made;
}

Result<void> Gpu::choose_buffer_access(std::optional<BufferAccess> access) {
  if (access) {
    buffer_access_ = *access;
  } else if (!has_useful_texels(limits())) {
    buffer_access_ = BufferAccess::kStorage;
  } else if (candidate_.kind == kProcessorKind &&
             limits().maxPerStageDescriptorStorageBuffers >= storage_buffers(BufferAccess::kStorage)) {
    const auto trial = try_buffer_access(*this);
    if (!trial) return trial.error();
    buffer_access_ = trial->faster();
  }
  return {};
}

Gpu::~Gpu() {
  if (device_ == VK_NULL_HANDLE) return;
  if (condition_ == Condition::kHung) {
    instance_.keep();
  } else {
    vkDestroyDevice(device_, nullptr);
  }
}

void Gpu::note_fault(Condition condition, const Error& error) const {
  if (fault_) return;
  condition_ = condition;
  fault_ = error;
}

void Gpu::wait_for_end() const {
  // Its result does not matter: a lost device has finished as well.
  vkDeviceWaitIdle(device_);
  condition_ = Condition::kLost;
}

void Gpu::set_debug_name(VkObjectType type, std::uint64_t handle, const char* name) const {
  if (name_object_ == nullptr) return;
  const VkDebugUtilsObjectNameInfoEXT info{.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT,
                                           .objectType = type,
                                           .objectHandle = handle,
                                           .pObjectName = name};
  name_object_(device_, &info);  // a name that cannot be set is no error
}

Result<std::uint32_t> Gpu::memory_type(std::uint32_t type_bits, VkMemoryPropertyFlags wanted,
                                       VkMemoryPropertyFlags preferred) const {
  for (const VkMemoryPropertyFlags flags : {wanted | preferred, wanted}) {
    for (std::uint32_t index = 0; index < memory_.memoryTypeCount; ++index) {
      const bool allowed = (type_bits >> index & 1U) != 0;
      if (allowed && (memory_.memoryTypes[index].propertyFlags & flags) == flags) return index;
    }
  }
  return Error{ErrorCode::kUnavailable,
               fmt::format("{} has no memory of the kind {:#x}", candidate_.name, wanted)};
}

}  // namespace fanlight
