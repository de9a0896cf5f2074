// SPDX-License-Identifier: Apache-2.0
#include "renderer/vulkan/render_device.hpp"

#include <utility>

namespace fanlight {

Result<RenderDevice> open_device(const std::string& name, const GpuInstance::Config& config) {
  auto instance = GpuInstance::create(config);
  if (!instance) return instance.error();
  auto gpu = Gpu::create(**instance, name);
  if (!gpu) return gpu.error();
  return RenderDevice{.instance = std::move(*instance), .gpu = std::move(*gpu)};
}

}  // namespace fanlight
