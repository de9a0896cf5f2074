// SPDX-License-Identifier: Apache-2.0
// With gpu_faults.cpp a library for LD_PRELOAD, which makes calls of Vulkan fail in a program as it ships.
//   FANLIGHT_GPU_FAULTS="CALL AFTER TIMES WHAT" CALL: submit, counter, memory, pipeline, pool or device.
//   AFTER: calls that pass before. TIMES: calls that are concerned. WHAT: lost, hangs, blocks, memory or
//   unknown; stands is for the counter. Several are separated by commas. FANLIGHT_GPU_FAULTS_FILE names a
//   file with the same, for a process that runs: it is read again when it changes; an empty one ends the
//   faults.
#include <dlfcn.h>
#include <vulkan/vulkan.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <thread>

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
                                     {"stands", VK_SUCCESS},
                                     {"memory", VK_ERROR_OUT_OF_DEVICE_MEMORY},
                                     {"unknown", VK_ERROR_UNKNOWN}},
                                    what);
  fault.hangs = what == "hangs";
  fault.blocks = what == "blocks";
  fault.stands = what == "stands";
  return fault;
}

void inject_all(const std::string& text) {
  std::istringstream faults(text);
  for (std::string each; std::getline(faults, each, ',');)
    if (each.find_first_not_of(" \n") != std::string::npos) inject(fault_of(each));
}

/// Follows the file until the process ends.
void follow(const std::filesystem::path& path) {
  std::string before;
  for (;;) {
    std::ifstream file(path);
    std::stringstream text;
    text << file.rdbuf();
    if (text.str() != before) {
      clear_gpu_faults();
      inject_all(before = text.str());
      std::fprintf(stderr, "FANLIGHT_GPU_FAULTS_FILE: read \"%s\"\n", before.c_str());
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
}

[[gnu::constructor]] void read_faults() {
  if (const char* const text = std::getenv("FANLIGHT_GPU_FAULTS")) inject_all(text);
  if (const char* const path = std::getenv("FANLIGHT_GPU_FAULTS_FILE"))
    std::thread(follow, std::filesystem::path(path)).detach();
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
