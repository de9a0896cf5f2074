// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <functional>
#include <utility>

#include "server/net/loop_chain.hpp"

namespace fanlight {

/// Calls a function again and again, in an event loop. Server thread only.
class LoopTimer {
 public:
  /// `loop` must outlive the timer. `interval`: from the end of a call to the next.
  LoopTimer(boost::asio::io_context& loop, std::chrono::milliseconds interval, std::function<void()> act)
      : interval_(interval), act_(std::move(act)), timer_(loop) {}

  /// Starts, unless it runs. Starts again where a lack of memory has ended it.
  void start() {
    if (chain_.broken()) wait();
  }

 private:
  void wait() {
    timer_.expires_after(interval_);
    timer_.async_wait([this, link = chain_.link()](boost::system::error_code failure) {
      if (failure) return;
      act_();
      wait();
    });
  }

  std::chrono::milliseconds interval_;
  std::function<void()> act_;
  boost::asio::steady_timer timer_;
  LoopChain chain_;
};

}  // namespace fanlight
