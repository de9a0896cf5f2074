// SPDX-License-Identifier: Apache-2.0
// With gpu_faults.cpp a library for LD_PRELOAD, which makes calls of Vulkan fail in a program as it ships.
//   FANLIGHT_GPU_FAULTS="CALL AFTER TIMES WHAT" CALL: submit, counter, memory, pipeline, pool or device.
//   AFTER: calls that pass before. TIMES: calls that are concerned. WHAT: lost, hangs, blocks, memory or
//   unknown. Several are separated by commas.
#include <dlfcn.h>
#include <vulkan/vulkan.h>

#include <cstdio>
#include <cstdlib>
#include <map>
#include <sstream>
#include <string>

#include "tests/gpu/gpu_faults.hpp"

namespace fanlight::test {
namespace {

/// Ends the process on a word that is not known: a test with a wrong word must not pass.
template <typename Value>
Value value_of(const std::map<std::string, Value>& known, const std::string& word) {
  const auto found = known.find(word);
  if (found != known.end()) return found->second;
  std::fprintf(stderr, "FANLIGHT_GPU_FAULTS: \"%s\" is not known\n", word.c_str());
  std::_Exit(3);
}

GpuFault fault_of(const std::string& text) {
  std::istringstream words(text);
  std::string call;
  std::string what;
  GpuFault fault;
  words >> call >> fault.after >> fault.times >> what;
  fault.call = value_of<GpuCall>({{"submit", GpuCall::kSubmit},
                                  {"counter", GpuCall::kSemaphoreValue},
                                  {"memory", GpuCall::kAllocateMemory},
                                  {"pipeline", GpuCall::kBuildPipeline},
                                  {"pool", GpuCall::kCommandPool},
                                  {"device", GpuCall::kCreateDevice}},
                                 call);
  fault.result = value_of<VkResult>({{"lost", VK_ERROR_DEVICE_LOST},
                                     {"hangs", VK_SUCCESS},
                                     {"blocks", VK_SUCCESS},
                                     {"memory", VK_ERROR_OUT_OF_DEVICE_MEMORY},
                                     {"unknown", VK_ERROR_UNKNOWN}},
                                    what);
  fault.hangs = what == "hangs";
  fault.blocks = what == "blocks";
  return fault;
}

[[gnu::constructor]] void read_faults() {
  const char* const text = std::getenv("FANLIGHT_GPU_FAULTS");
  std::istringstream faults(text == nullptr ? "" : text);
  for (std::string each; std::getline(faults, each, ',');) inject(fault_of(each));
}

}  // namespace
}  // namespace fanlight::test

extern "C" VKAPI_ATTR VkResult VKAPI_CALL vkAllocateMemory(VkDevice device, const VkMemoryAllocateInfo* info,
                                                           const VkAllocationCallbacks* callbacks,
                                                           VkDeviceMemory* memory) {
  using namespace fanlight::test;
  static const auto allocate = reinterpret_cast<PFN_vkAllocateMemory>(dlsym(RTLD_NEXT, "vkAllocateMemory"));
  if (const auto injected = injected_result(device, GpuCall::kAllocateMemory)) return *injected;
  return allocate(device, info, callbacks, memory);
}
