// SPDX-License-Identifier: Apache-2.0
// Interposes the Vulkan calls that our code may make only before its threads are hot: allocations of GPU
// memory and creation of pipelines. Allocations inside the driver are permitted; these calls themselves are
// not.
#include <vulkan/vulkan.h>

#include "tests/hot_path/hot_threads.hpp"
#include "tests/hot_path/next_function.hpp"

using fanlight::test::check_call;
using fanlight::test::NextFunction;

namespace {

using Allocate = VkResult(VkDevice, const VkMemoryAllocateInfo*, const VkAllocationCallbacks*,
                          VkDeviceMemory*);
using Free = void(VkDevice, VkDeviceMemory, const VkAllocationCallbacks*);
using BuildPipelines = VkResult(VkDevice, VkPipelineCache, std::uint32_t, const VkComputePipelineCreateInfo*,
                                const VkAllocationCallbacks*, VkPipeline*);

constinit NextFunction<Allocate> next_allocate("vkAllocateMemory");
constinit NextFunction<Free> next_free("vkFreeMemory");
constinit NextFunction<BuildPipelines> next_pipelines("vkCreateComputePipelines");

}  // namespace

extern "C" {

VkResult vkAllocateMemory(VkDevice device, const VkMemoryAllocateInfo* info,
                          const VkAllocationCallbacks* callbacks, VkDeviceMemory* memory) {
  check_call("vkAllocateMemory", __builtin_return_address(0));
  return next_allocate(device, info, callbacks, memory);
}

void vkFreeMemory(VkDevice device, VkDeviceMemory memory, const VkAllocationCallbacks* callbacks) {
  check_call("vkFreeMemory", __builtin_return_address(0));
  next_free(device, memory, callbacks);
}

VkResult vkCreateComputePipelines(VkDevice device, VkPipelineCache cache, std::uint32_t count,
                                  const VkComputePipelineCreateInfo* infos,
                                  const VkAllocationCallbacks* callbacks, VkPipeline* pipelines) {
  check_call("vkCreateComputePipelines", __builtin_return_address(0));
  return next_pipelines(device, cache, count, infos, callbacks, pipelines);
}

}  // extern "C"
