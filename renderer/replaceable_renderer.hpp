// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <stop_token>

#include "proto/exchange/render_link.hpp"
#include "proto/model/pipeline_counters.hpp"
#include "renderer/device_disposal.hpp"
#include "renderer/health_reporter.hpp"
#include "renderer/renderer.hpp"
#include "renderer/schedule/loss_record.hpp"

namespace fanlight {

/// The renderer of the render thread. Where the GPU is lost, hangs or has no memory left, a new device and a
/// new renderer take its place; numbers of pictures and counters continue. Gives up where LossRecord says so.
/// Render thread only, except is_gone().
class ReplaceableRenderer {
 public:
  /// Opens a device and creates a renderer of this scene. May block for seconds.
  using Remake = std::function<Result<DeviceRenderer>(const NumberedScene& scene)>;

  /// All must outlive this object.
  struct Dependencies {
    RenderLink& link;
    RenderCounters& counters;
    HealthReporter& health;
    Remake remake{};  ///< empty: a lost GPU is not replaced
  };

  ReplaceableRenderer(DeviceRenderer renderer, const Dependencies& dependencies)
      : to_(dependencies), device_(std::move(renderer)) {}

  Renderer& operator*() { return *device_.renderer; }
  Renderer* operator->() { return device_.renderer.get(); }
  const Renderer* operator->() const { return device_.renderer.get(); }
  bool can_be_replaced() const { return static_cast<bool>(to_.remake); }

  /// Replaces the renderer after an error of it. The new one shows the last scene that could be drawn, and
  /// has no volume and no private views. False: `stop` was requested, or it gave up and has sent an Error;
  /// there is no renderer then. Blocks until a driver opens its device again, for seconds.
  bool replace(const Error& cause, const std::stop_token& stop);

  void note_picture() { losses_.picture_finished(); }

  /// Sends an Error: the thread ends.
  void fail(const Error& error) { to_.link.answer(error); }

  /// Destroys the renderer, after it has finished what it can within settle_ns.
  void end(std::int64_t settle_ns);

  /// Whether nothing is left of the devices before. Any thread.
  bool is_gone() const { return disposal_.idle(); }

 private:
  bool remake(const NumberedScene& scene, const std::stop_token& stop);
  void dispose(const Error& cause);
  void pause(std::int64_t until_ns, const std::stop_token& stop) const;

  Dependencies to_;
  DeviceRenderer device_;
  LossRecord losses_;
  DeviceDisposal disposal_;
};

}  // namespace fanlight
