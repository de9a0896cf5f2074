// SPDX-License-Identifier: Apache-2.0
#include "renderer/vulkan/device_health.hpp"

namespace fanlight {

const Error* DeviceHealth::fault() const {
  // The device without a fault may still work on what was submitted, so its objects are left as those of a
  // device that hangs, until it has finished.
  if (gpu_.fault() != nullptr) light_gpu_.note_fault(Gpu::Condition::kHung, *gpu_.fault());
  if (light_gpu_.fault() != nullptr) gpu_.note_fault(Gpu::Condition::kHung, *light_gpu_.fault());
  return gpu_.fault();
}

Gpu::Condition DeviceHealth::condition() const {
  using enum Gpu::Condition;
  static_cast<void>(fault());
  // Where one is lost, the other one is no reason to say that the GPU hangs.
  const bool lost = either_lost_ || gpu_.condition() == kLost || light_gpu_.condition() == kLost;
  return lost ? kLost : gpu_.condition();
}

void DeviceHealth::note_fault(Gpu::Condition condition, const Error& error) const {
  // Which of two devices is lost is not known here, and the other one may be at work: both are waited for.
  either_lost_ |= condition == Gpu::Condition::kLost;
  gpu_.note_fault(on_one_device() ? condition : Gpu::Condition::kHung, error);
  static_cast<void>(fault());
}

bool DeviceHealth::is_at_work() const {
  return gpu_.condition() == Gpu::Condition::kHung || light_gpu_.condition() == Gpu::Condition::kHung;
}

void DeviceHealth::wait_for_end() const {
  for (const Gpu* const gpu : {&gpu_, &light_gpu_}) {
    if (gpu->condition() == Gpu::Condition::kHung) gpu->wait_for_end();
  }
}

}  // namespace fanlight
