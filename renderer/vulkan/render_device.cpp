// SPDX-License-Identifier: Apache-2.0
#include "renderer/vulkan/render_device.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <future>
#include <utility>

#include "proto/base/low_priority.hpp"

namespace fanlight {

namespace {

// lavapipe with its compiler takes 1.4 to 1.7 GB of addresses, of which it uses a fifth, and 1.9 GB with two
// devices; with less it ends the process in the midst of its work. Drivers of GPUs take more.
constexpr rlim_t kLeastAddressBytes = 2'000'000'000;

Result<void> check_address_space() {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur >= kLeastAddressBytes) return {};
  return Error{
      ErrorCode::kUnavailable,
      fmt::format("the system allows this process {} MB of addresses (ulimit -v), expected at least {}, "
                  "which the GPU's driver takes",
                  limit.rlim_cur / 1'000'000, kLeastAddressBytes / 1'000'000)};
}

bool is_processor(const GpuCandidate* candidate) {
  return candidate != nullptr && candidate->kind == kProcessorKind;
}

Result<RenderDevice> open_one(const std::string& name, const DeviceOptions& options) {
  auto instance = GpuInstance::create(options.instance);
  if (!instance) return instance.error();
  const auto create = [&] { return Gpu::create(**instance, name, options.access); };
  const auto create_in_background = [&] {
    lower_priority(kCastNiceness);  // which the driver's threads inherit
    return create();
  };
  const bool lowered = options.in_background && is_processor((*instance)->candidate(name));
  auto gpu = lowered ? std::async(std::launch::async, create_in_background).get() : create();
  if (!gpu) return gpu.error();
  return RenderDevice{.instance = std::move(*instance), .gpu = std::move(*gpu)};
}

}  // namespace

void RenderDevice::reset() {
  light_gpu.reset();
  light_instance.reset();
  gpu.reset();
  instance.reset();
}

Result<RenderDevice> open_device(const std::string& name, const DeviceOptions& options) {
  if (auto room = check_address_space(); !room) return room.error();
  DeviceOptions of_light = options;
  of_light.in_background = options.in_background && !options.own_light_device;
  auto opened = open_one(name, of_light);
  if (!opened || !options.own_light_device || !is_processor(&opened->gpu->candidate())) return opened;
  DeviceOptions same = options;
  same.access = opened->gpu->buffer_access();
  auto cast = open_one(opened->name(), same);
  if (!cast) {
    // One device does the work of two, only slower.
    opened->light_refusal = cast.error().message;
    return opened;
  }
  cast->light_instance = std::move(opened->instance);
  cast->light_gpu = std::move(opened->gpu);
  return cast;
}

}  // namespace fanlight
