// SPDX-License-Identifier: Apache-2.0
#include "tests/hot_path/call_origin.hpp"

#include <cxxabi.h>
#include <dlfcn.h>
#include <fmt/format.h>
#include <link.h>
#include <unwind.h>

#include <cstdlib>
#include <optional>
#include <string_view>

namespace fanlight::test {

namespace {

/// Calls visit(return address) for the frame with return address `caller` and each outer frame, until it
/// returns false. Inner frames, those of the hook, are skipped.
template <typename Visit>
void unwind(const void* caller, Visit visit) {
  struct State {
    std::uintptr_t caller;
    Visit& visit;
    bool begun = false;
  } state{.caller = reinterpret_cast<std::uintptr_t>(caller), .visit = visit};
  _Unwind_Backtrace(
      [](_Unwind_Context* frame, void* context) {
        auto& unwind = *static_cast<State*>(context);
        const std::uintptr_t address = _Unwind_GetIP(frame);
        unwind.begun = unwind.begun || address == unwind.caller;
        const bool go_on = address != 0 && (!unwind.begun || unwind.visit(address));
        return go_on ? _URC_NO_REASON : _URC_END_OF_STACK;
      },
      &state);
}

/// The call before a return address. The return address itself may lie behind the end of the function.
void* call_before(std::uintptr_t address) {
  return reinterpret_cast<void*>(address - 1);
}

std::optional<Origin> origin_of_frame(std::uintptr_t address) {
  // Not dladdr(): it locks.
  dl_find_object object{};
  if (_dl_find_object(call_before(address), &object) != 0) return std::nullopt;
  const std::string_view path = object.dlfo_link_map->l_name;
  if (path.empty()) return Origin::kOurs;  // the dynamic linker's name of the program itself
  const std::string_view file = path.substr(path.rfind('/') + 1);
  for (const std::string_view driver : {"libvulkan", "libVkLayer", "libLLVM", "libnvidia", "libGLX_nvidia"}) {
    if (file.starts_with(driver)) return Origin::kDriver;
  }
  return std::nullopt;
}

std::string description(std::uintptr_t address) {
  Dl_info found{};
  if (dladdr(call_before(address), &found) == 0) return fmt::format("{:#x}", address);
  const std::string_view path = found.dli_fname;
  const auto base = reinterpret_cast<std::uintptr_t>(found.dli_fbase);
  const std::string offset = fmt::format("{}+{:#x}", path.substr(path.rfind('/') + 1), address - 1 - base);
  if (found.dli_sname == nullptr) return offset;
  int failed = 0;
  char* const readable = abi::__cxa_demangle(found.dli_sname, nullptr, nullptr, &failed);
  const std::string name = failed == 0 ? readable : found.dli_sname;
  std::free(readable);
  return fmt::format("{} ({})", name, offset);
}

}  // namespace

Origin origin_of(const void* caller) {
  Origin origin = Origin::kOurs;
  unwind(caller, [&origin](std::uintptr_t address) {
    const std::optional<Origin> known = origin_of_frame(address);
    if (known) origin = *known;
    return !known;
  });
  return origin;
}

std::vector<std::string> stack_from(const void* caller) {
  std::vector<std::string> descriptions;
  unwind(caller, [&descriptions](std::uintptr_t address) {
    descriptions.push_back(description(address));
    return true;
  });
  return descriptions;
}

}  // namespace fanlight::test
