// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>

#include "renderer/renderer.hpp"
#include "renderer/vulkan/render_device.hpp"

namespace fanlight {

/// A renderer, and the device that it renders with where it owns that device.
struct DeviceRenderer {
  RenderDevice device;  ///< empty where the device has another owner
  std::unique_ptr<Renderer> renderer;

  /// Destroys the renderer, then the device. May block as long as the watchdog allows.
  void reset() {
    renderer.reset();
    device.reset();
  }
};

/// Destroys renderers whose GPU was lost or hangs, each on a detached thread: a driver may never return from
/// the destruction of such a device. What it does not return from is never freed. While idle() is false, the
/// process must end by std::_Exit: the thread is inside the driver, whose static objects an orderly end would
/// destroy.
class DeviceDisposal {
 public:
  DeviceDisposal();

  /// Starts the destruction. Calls Renderer::give_up(). Allocates and starts a thread.
  void take(DeviceRenderer renderer);

  /// Blocks until nothing is left, at most timeout_ns. Whether that is so.
  bool wait(std::int64_t timeout_ns) const;

  /// Whether nothing is left. Any thread.
  bool idle() const { return wait(0); }

 private:
  struct State;
  std::shared_ptr<State> state_;  // shared with the threads, which may outlive this object
};

}  // namespace fanlight
