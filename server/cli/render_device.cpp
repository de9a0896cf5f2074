// SPDX-License-Identifier: Apache-2.0
#include "server/cli/render_device.hpp"

#include <utility>

namespace fanlight {

Result<RenderDevice> open_device(const std::string& name) {
  auto instance = GpuInstance::create({});
  if (!instance) return instance.error();
  auto gpu = Gpu::create(**instance, name);
  if (!gpu) return gpu.error();
  return RenderDevice{.instance = std::move(*instance), .gpu = std::move(*gpu)};
}

}  // namespace fanlight
