// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <stdexcept>

#include "renderer/vulkan/gpu.hpp"

namespace fanlight::test {

/// The GPU as in production, without validation layers. One for the process, created at the first call.
/// Throws std::runtime_error without a GPU.
inline const Gpu& plain_gpu() {
  struct Rig {
    std::unique_ptr<GpuInstance> instance;
    std::unique_ptr<Gpu> gpu;
  };
  static const Rig rig = [] {
    auto instance = GpuInstance::create({});
    if (!instance) throw std::runtime_error(instance.error().message);
    auto gpu = Gpu::create(**instance, "");
    if (!gpu) throw std::runtime_error(gpu.error().message);
    return Rig{std::move(*instance), std::move(*gpu)};
  }();
  return *rig.gpu;
}

}  // namespace fanlight::test
