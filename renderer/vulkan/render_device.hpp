// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "proto/base/result.hpp"
#include "renderer/vulkan/gpu.hpp"

namespace fanlight {

/// A device to render with, and the Vulkan instance that it belongs to.
struct RenderDevice {
  std::unique_ptr<GpuInstance> instance;
  std::unique_ptr<Gpu> gpu;  // after the instance, which must outlive it

  const std::string& name() const { return gpu->candidate().name; }
};

/// `name`: part of the GPU's name; empty for the best one. Errors: too little address space for the
/// driver; those of GpuInstance::create and Gpu::create.
/// `access`: see Gpu::create().
Result<RenderDevice> open_device(const std::string& name, const GpuInstance::Config& config = {},
                                 std::optional<BufferAccess> access = std::nullopt);

}  // namespace fanlight
