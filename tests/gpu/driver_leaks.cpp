// SPDX-License-Identifier: Apache-2.0
// For the leak checker. lavapipe and the validation layer keep memory until the process ends. They are
// unloaded before the checker runs, which then cannot attribute their memory. So they stay loaded here, and
// their leaks are suppressed by name. Our own allocations are still checked; the layer counts Vulkan objects
// that are not destroyed.
#include <dlfcn.h>

namespace {

[[maybe_unused]] void* const kKeptLoaded[] = {
    dlopen("libvulkan_lvp.so", RTLD_LAZY | RTLD_NODELETE),
    dlopen("libVkLayer_khronos_validation.so", RTLD_LAZY | RTLD_NODELETE)};

}  // namespace

// The sanitizer defines this name.
extern "C" const char* __lsan_default_suppressions();   // NOLINT
extern "C" const char* __lsan_default_suppressions() {  // NOLINT
  return "leak:libvulkan_lvp\nleak:libLLVM\nleak:libVkLayer\n";
}
