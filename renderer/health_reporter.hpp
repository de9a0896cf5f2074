// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

#include "proto/base/thread_owner.hpp"
#include "proto/exchange/render_link.hpp"

namespace fanlight {

/// Sends the health of the renderer to the server, whenever it changes and only then. Render thread only.
/// Allocates nothing.
class HealthReporter {
 public:
  /// `link` must outlive this object.
  explicit HealthReporter(RenderLink& link) : link_(link) {}

  /// `cause`: a sentence; empty for kRunning.
  void set_state(RenderHealth::State state, std::string_view cause, std::int64_t now_ns);

  /// Why the newest volume was refused; empty: it was taken.
  void set_volume_refusal(std::string_view reason);
  /// Why the newest scene is not shown; empty: it is. A refused volume is reported before a refused scene.
  void set_scene_refusal(std::string_view reason);

  /// Counts a loss; the next change of the state publishes it.
  void count_loss() { ++health_.devices_lost; }

  /// Whether the server had no room for the newest state.
  bool is_due() const { return due_; }
  /// Sends again what the server had no room for.
  void flush() {
    if (due_) send();
  }

  const RenderHealth& health() const { return health_; }

 private:
  using Sentence = decltype(RenderHealth::cause);
  void update_refusal();
  void send() { due_ = !link_.answer(health_); }

  RenderLink& link_;
  RenderHealth health_;
  Sentence volume_refusal_;
  Sentence scene_refusal_;
  bool due_ = false;
  [[no_unique_address]] ThreadOwner thread_owner_;
};

}  // namespace fanlight
