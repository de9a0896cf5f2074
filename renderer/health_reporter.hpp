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
  /// Why the scene of this revision is not drawn; empty: it is.
  void set_scene_refusal(std::uint64_t revision, std::string_view reason);

  /// Whether the volume shown lacks the speckle filter of its scene.
  void set_filter_left_out(bool left_out);

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
  void send() { due_ = !link_.answer(health_); }

  RenderLink& link_;
  RenderHealth health_;
  bool due_ = false;
  [[no_unique_address]] ThreadOwner thread_owner_;
};

}  // namespace fanlight
