// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

#include "proto/exchange/mailbox.hpp"
#include "proto/exchange/render_health.hpp"

namespace fanlight {

/// Publishes the health of the renderer in a mailbox, whenever it changes and only then. Render thread only.
/// No function allocates as long as the sentences are shorter than those of roomy_health().
class HealthReporter {
 public:
  /// `to` must outlive this object; null: nothing is published.
  explicit HealthReporter(Mailbox<RenderHealth>* to);

  /// `cause`: a sentence; empty for kRunning.
  void set_state(RenderHealth::State state, std::string_view cause, std::int64_t now_ns);

  /// Why the newest volume was refused; empty: it was taken.
  void set_volume_refusal(std::string_view reason);
  /// Why the newest scene is not shown; empty: it is. A refused volume is reported before a refused scene.
  void set_scene_refusal(std::string_view reason);

  /// Counts a loss; the next change of the state publishes it.
  void count_loss() { ++health_.devices_lost; }

  const RenderHealth& health() const { return health_; }

 private:
  void update_refusal();
  void publish();

  Mailbox<RenderHealth>* to_;
  RenderHealth health_;
  std::string volume_refusal_;
  std::string scene_refusal_;
};

/// A value for the slots of the mailbox, whose sentences have room for those of the renderer.
RenderHealth roomy_health();

}  // namespace fanlight
