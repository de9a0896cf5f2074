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

Result<RenderDevice> open_one(const std::string& name, const DeviceOptions& options) {
  auto instance = GpuInstance::create(options.instance);
  if (!instance) return instance.error();
  auto gpu = Gpu::create(**instance, name, options.access);
  if (!gpu) return gpu.error();
  return RenderDevice{.instance = std::move(*instance), .gpu = std::move(*gpu)};
}

/// The same on a thread of lower priority, which the driver's threads inherit: a moved light, the encoder and
/// the network go before pass 1.
Result<RenderDevice> open_in_background(const std::string& name, const DeviceOptions& options) {
  return std::async(std::launch::async,
                    [&] {
                      lower_priority(kCastNiceness);
                      return open_one(name, options);
                    })
      .get();
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
  auto opened = open_one(name, options);
  if (!opened || !options.own_light_device || opened->gpu->candidate().kind != kProcessorKind) return opened;
  DeviceOptions same = options;
  same.access = opened->gpu->buffer_access();
  auto cast = open_in_background(opened->name(), same);
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
