// What our code may ask of the GPU's driver only before its threads are hot: memory and pipelines. What the
// driver allocates for that, or for any other call, is its own affair; that it was asked is ours.
#include <vulkan/vulkan.h>

#include "tests/hot_path/hot_threads.hpp"
#include "tests/hot_path/next_function.hpp"

using fanlight::test::look_at;
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
  look_at("vkAllocateMemory", __builtin_return_address(0));
  return next_allocate(device, info, callbacks, memory);
}

void vkFreeMemory(VkDevice device, VkDeviceMemory memory, const VkAllocationCallbacks* callbacks) {
  look_at("vkFreeMemory", __builtin_return_address(0));
  next_free(device, memory, callbacks);
}

VkResult vkCreateComputePipelines(VkDevice device, VkPipelineCache cache, std::uint32_t count,
                                  const VkComputePipelineCreateInfo* infos,
                                  const VkAllocationCallbacks* callbacks, VkPipeline* pipelines) {
  look_at("vkCreateComputePipelines", __builtin_return_address(0));
  return next_pipelines(device, cache, count, infos, callbacks, pipelines);
}

}  // extern "C"
