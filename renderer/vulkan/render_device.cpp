// SPDX-License-Identifier: Apache-2.0
#include "renderer/vulkan/render_device.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <utility>

namespace fanlight {

namespace {

// lavapipe with its compiler takes 1.4 to 1.7 GB of addresses, of which it uses a fifth; with less it ends
// the process in the midst of its work. Drivers of GPUs take more.
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

}  // namespace

Result<RenderDevice> open_device(const std::string& name, const GpuInstance::Config& config,
                                 std::optional<BufferAccess> access) {
  if (auto room = check_address_space(); !room) return room.error();
  auto instance = GpuInstance::create(config);
  if (!instance) return instance.error();
  auto gpu = Gpu::create(**instance, name, access);
  if (!gpu) return gpu.error();
  return RenderDevice{.instance = std::move(*instance), .gpu = std::move(*gpu)};
}

}  // namespace fanlight
