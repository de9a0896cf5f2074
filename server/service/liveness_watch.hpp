// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/io_context.hpp>
#include <functional>

#include "server/net/loop_timer.hpp"
#include "server/service/scene_guard.hpp"
#include "server/state/server_state.hpp"
#include "server/stream/picture_hub.hpp"
#include "server/stream/session_registry.hpp"

namespace fanlight {

/// Updates PictureDemand and PictureLiveness several times a second; notifies sessions, and logs what has
/// changed. Server thread only.
class LivenessWatch {
 public:
  /// All must outlive this object.
  struct Dependencies {
    ServerState& state;
    PictureHub& hub;
    SessionRegistry& sessions;
    SceneGuard& scene;
    std::function<std::size_t()> other_clients;  ///< that need pictures, and are no sessions
    std::function<void()> changed;               ///< the liveness has changed
  };
  LivenessWatch(boost::asio::io_context& loop, const Dependencies& dependencies);

  /// Starts; lasts as long as the loop. Starts again where a lack of memory has ended it.
  void start() { timer_.start(); }

  /// Looks now: something has changed.
  void update();

 private:
  void log() const;

  Dependencies dependencies_;
  LoopTimer timer_;
};

}  // namespace fanlight
