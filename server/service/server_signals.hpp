// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <functional>

#include "server/net/loop_chain.hpp"

namespace fanlight {

/// The signals that the server answers, in its loop. Server thread only.
///
///   SIGTERM, SIGINT   the first ends the server in good order, the second at once
///   SIGHUP            reads tokens and certificates again, and opens the audit log again if it was moved
///   SIGUSR1           writes a line about the state of the server to the log
class ServerSignals {
 public:
  struct Actions {
    std::function<void()> end;
    std::function<void()> end_now;
    std::function<void()> read_again;
    std::function<void()> log_state;
  };

  ServerSignals(boost::asio::io_context& loop, Actions actions);

  /// Calls the actions from now on. Begins again where a lack of memory has ended it.
  void start();

  /// SIGTERM and SIGINT end the process again.
  void release_ends();

 private:
  void wait();
  void received(int signal);

  Actions actions_;
  boost::asio::signal_set signals_;
  LoopChain chain_;
  bool ending_ = false;
};

}  // namespace fanlight
