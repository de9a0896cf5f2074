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
  // On a processor, where asked for: passes 2 and 3 have a device of their own. A driver on the processor has
  // one set of threads for each instance, so that only two instances work at the same time.
  std::unique_ptr<GpuInstance> light_instance;
  std::unique_ptr<Gpu> light_gpu;
  std::string light_refusal;  ///< why there is none, although it was asked for and should be; else empty

  const std::string& name() const { return gpu->candidate().name; }
  /// Destroys the devices, then their instances.
  void reset();
};

struct DeviceOptions {
  GpuInstance::Config instance{};
  /// See Gpu::create().
  std::optional<BufferAccess> access{};
  /// Opens RenderDevice::light_gpu too, where the device is a processor.
  bool own_light_device = false;
  /// Where the device of pass 1 is a processor, the threads of its driver get a lower priority: the encoder,
  /// the network and, with an own_light_device, a moved light go before them.
  bool in_background = false;
};

/// `name`: part of the GPU's name; empty for the best one. Errors: too little address space for the
/// driver; those of GpuInstance::create and Gpu::create.
Result<RenderDevice> open_device(const std::string& name, const DeviceOptions& options = {});

}  // namespace fanlight
