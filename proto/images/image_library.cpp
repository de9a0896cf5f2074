// SPDX-License-Identifier: Apache-2.0
#include "proto/images/image_library.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

#include <atomic>
#include <string_view>

#include "proto/base/version.hpp"

namespace fanlight {

namespace {

// Found by the run path of the program: ../lib/fanlight beside it.
constexpr const char* kFile = "libfanlight-images.so";

Result<ImageLibrary*> load_image_library() {
  const auto unavailable = [](std::string_view reason) {
    return Error{ErrorCode::kUnavailable,
                 fmt::format("pictures in files cannot be read or written ({}), expected {} {} in "
                             "../lib/fanlight beside the program (package fanlight-images)",
                             reason, kFile, version())};
  };
  void* const library = dlopen(kFile, RTLD_NOW | RTLD_LOCAL);
  // NOLINTNEXTLINE(concurrency-mt-unsafe): glibc keeps the text for each thread.
  if (library == nullptr) return unavailable(dlerror());
  using MadeFor = const char* (*)();
  using Open = ImageLibrary* (*)();
  const auto made_for = reinterpret_cast<MadeFor>(dlsym(library, "fanlight_images_version"));
  const auto open = reinterpret_cast<Open>(dlsym(library, "fanlight_images_open"));
  // An upgrade may have replaced it while this program runs.
  if (made_for == nullptr || open == nullptr || std::string_view(made_for()) != version())
    return unavailable(fmt::format("{} is of another version", kFile));
  return open();
}

}  // namespace

Result<ImageLibrary*> image_library() {
  // A failure is tried again: it may have been a lack of memory.
  static std::atomic<ImageLibrary*> loaded = nullptr;
  if (ImageLibrary* const library = loaded) return library;
  Result<ImageLibrary*> library = load_image_library();
  if (library) loaded = *library;
  return library;
}

}  // namespace fanlight
