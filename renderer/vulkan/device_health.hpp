// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "proto/base/result.hpp"
#include "renderer/vulkan/gpu.hpp"

namespace fanlight {

/// Whether the device of a renderer works, or its two: that of pass 1, and that of passes 2 and 3. A fault of
/// one counts as a fault of both. Render thread only.
class DeviceHealth {
 public:
  /// The same twice where there is one device. Both must outlive this object.
  DeviceHealth(const Gpu& gpu, const Gpu& light_gpu) : gpu_(gpu), light_gpu_(light_gpu) {}

  bool on_one_device() const { return &gpu_ == &light_gpu_; }

  /// The first error of either device; nullptr: none.
  const Error* fault() const;
  /// kLost where either is lost.
  Gpu::Condition condition() const;
  /// As Gpu::note_fault(), of either device.
  void note_fault(Gpu::Condition condition, const Error& error) const;
  /// Whether a device may still use its memory after a fault.
  bool is_at_work() const;
  /// As Gpu::wait_for_end(), of each device that hangs.
  void wait_for_end() const;

 private:
  const Gpu& gpu_;
  const Gpu& light_gpu_;
  mutable bool either_lost_ = false;  // of note_fault()
};

}  // namespace fanlight
