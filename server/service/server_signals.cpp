// SPDX-License-Identifier: Apache-2.0
#include "server/service/server_signals.hpp"

#include <csignal>
#include <utility>

namespace fanlight {

ServerSignals::ServerSignals(boost::asio::io_context& loop, Actions actions)
    : actions_(std::move(actions)), signals_(loop) {}

void ServerSignals::start() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGUSR1}) {
    boost::system::error_code ignored;
    signals_.add(signal, ignored);
  }
  if (chain_.broken()) wait();
}

void ServerSignals::release_ends() {
  for (const int signal : {SIGINT, SIGTERM}) {
    boost::system::error_code ignored;
    signals_.remove(signal, ignored);
  }
}

void ServerSignals::wait() {
  signals_.async_wait([this, link = chain_.link()](boost::system::error_code failure, int signal) {
    if (failure) return;
    received(signal);
    wait();
  });
}

void ServerSignals::received(int signal) {
  switch (signal) {
    case SIGHUP:
      return actions_.read_again();
    case SIGUSR1:
      return actions_.log_state();
    default:
      if (std::exchange(ending_, true)) return actions_.end_now();
      return actions_.end();
  }
}

}  // namespace fanlight
