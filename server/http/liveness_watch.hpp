// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <functional>
#include <string>

#include "proto/exchange/mailbox.hpp"
#include "proto/exchange/render_health.hpp"
#include "server/net/loop_chain.hpp"
#include "server/state/cine_proxy.hpp"
#include "server/state/picture_demand.hpp"
#include "server/state/picture_liveness.hpp"
#include "server/state/probe_proxy.hpp"
#include "server/state/recording_proxy.hpp"
#include "server/state/replay_proxy.hpp"
#include "server/stream/picture_hub.hpp"
#include "server/stream/session_registry.hpp"

namespace fanlight {

/// Brings PictureDemand and PictureLiveness up to date several times a second; tells sessions and the log
/// what has changed.
/// Server thread only.
class LivenessWatch {
 public:
  /// All must outlive this object.
  struct Dependencies {
    PictureLiveness& liveness;
    const ProbeProxy& probe;
    const ReplayProxy& replay;
    const CineProxy& cine;
    const RecordingProxy& recording;
    PictureDemand& demand;
    PictureHub& hub;
    const std::function<std::string()>& source_state;  ///< "running", "ended", or why it failed
    Mailbox<RenderHealth>* health;                     ///< null: the renderer is always well
    SessionRegistry& sessions;
    std::function<std::size_t()> other_clients{};  ///< who need pictures and are no sessions; empty: none
    std::function<void()> changed{};               ///< the liveness; may be empty
  };
  LivenessWatch(boost::asio::io_context& loop, const Dependencies& dependencies)
      : dependencies_(dependencies), pause_(loop) {}

  /// Begins; lasts as long as the loop. Begins again where a lack of memory has ended it.
  void start();

  /// Looks now: something has changed.
  void update();

 private:
  void wait();
  void log() const;

  Dependencies dependencies_;
  boost::asio::steady_timer pause_;
  LoopChain chain_;
};

}  // namespace fanlight
