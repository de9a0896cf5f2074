// For the leak checker. lavapipe and the validation layer keep memory to the end of the process; they are
// unloaded before it looks, and then what is not ours has no name any more. So they stay loaded here, and
// their names are given. What we allocate ourselves, for the GPU too, is still checked: the layer counts
// objects left behind.
#include <dlfcn.h>

namespace {

[[maybe_unused]] void* const kKeptLoaded[] = {
    dlopen("libvulkan_lvp.so", RTLD_LAZY | RTLD_NODELETE),
    dlopen("libVkLayer_khronos_validation.so", RTLD_LAZY | RTLD_NODELETE)};

}  // namespace

// The name is the sanitizer's.
extern "C" const char* __lsan_default_suppressions();   // NOLINT
extern "C" const char* __lsan_default_suppressions() {  // NOLINT
  return "leak:libvulkan_lvp\nleak:libLLVM\nleak:libVkLayer\n";
}
