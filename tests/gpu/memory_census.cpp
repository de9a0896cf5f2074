// SPDX-License-Identifier: Apache-2.0
// Defines vkAllocateMemory and vkFreeMemory in the program; the linker prefers them to the loader's.
#include "tests/gpu/memory_census.hpp"

#include <dlfcn.h>
#include <vulkan/vulkan.h>

#include <map>
#include <mutex>

#include "tests/gpu/gpu_faults.hpp"

namespace fanlight::test {
namespace {

struct Ledger {
  std::mutex mutex;
  std::uint64_t taken = 0;
  std::map<VkDeviceMemory, std::uint64_t> held_bytes;
};

Ledger& ledger() {
  static Ledger made;
  return made;
}

template <typename Function>
Function loaders(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

}  // namespace

MemoryCensus MemoryCensus::now() {
  const std::scoped_lock lock(ledger().mutex);
  MemoryCensus census{.taken = ledger().taken, .held = ledger().held_bytes.size()};
  for (const auto& [memory, bytes] : ledger().held_bytes) census.held_bytes += bytes;
  return census;
}

}  // namespace fanlight::test

extern "C" {

VKAPI_ATTR VkResult VKAPI_CALL vkAllocateMemory(VkDevice device, const VkMemoryAllocateInfo* info,
                                                const VkAllocationCallbacks* callbacks,
                                                VkDeviceMemory* memory) {
  using namespace fanlight::test;
  static const auto allocate = loaders<PFN_vkAllocateMemory>("vkAllocateMemory");
  if (const auto injected = injected_result(device, GpuCall::kAllocateMemory)) return *injected;
  const VkResult result = allocate(device, info, callbacks, memory);
  if (result != VK_SUCCESS) return result;
  const std::scoped_lock lock(ledger().mutex);
  ++ledger().taken;
  ledger().held_bytes[*memory] = info->allocationSize;
  return result;
}

VKAPI_ATTR void VKAPI_CALL vkFreeMemory(VkDevice device, VkDeviceMemory memory,
                                        const VkAllocationCallbacks* callbacks) {
  using namespace fanlight::test;
  static const auto free = loaders<PFN_vkFreeMemory>("vkFreeMemory");
  {
    // Before the memory is freed: the driver may reuse its handle at once.
    const std::scoped_lock lock(ledger().mutex);
    ledger().held_bytes.erase(memory);
  }
  free(device, memory, callbacks);
}

}  // extern "C"
