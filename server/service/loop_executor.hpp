// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/io_context.hpp>
#include <functional>

#include "server/codec/encoder_pool.hpp"

namespace fanlight {

/// Runs work on the threads of the encoders, and what follows from it in an event loop. Server thread only.
class LoopExecutor {
 public:
  /// `loop` must outlive this object.
  explicit LoopExecutor(boost::asio::io_context& loop) : loop_(loop) {}

  /// Runs `work` on a thread of the lane, and then `done` in the loop, where `done` is destroyed too. Nothing
  /// is lost where memory is short: the thread waits for it.
  void run(EncoderLane lane, std::function<void()> work, std::function<void()> done);

 private:
  boost::asio::io_context& loop_;
  EncoderPool encoders_;
};

}  // namespace fanlight
