// SPDX-License-Identifier: Apache-2.0
#include "server/cli/own_terminal.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>

namespace fanlight {

namespace {

/// Other errors, such as a lack of descriptors, say nothing about the terminal.
bool has_no_terminal() {
  const int terminal = open("/dev/tty", O_RDONLY | O_NOCTTY | O_CLOEXEC);
  if (terminal >= 0) close(terminal);
  return terminal < 0 && (errno == ENXIO || errno == EIO);
}

}  // namespace

OwnTerminal::OwnTerminal() {
  struct sigaction hangup {};
  sigaction(SIGHUP, nullptr, &hangup);
  is_owner_ = hangup.sa_handler != SIG_IGN && !has_no_terminal();
}

bool OwnTerminal::has_closed() const {
  return is_owner_ && has_no_terminal();
}

void OwnTerminal::second_passed() {
  const bool absent = has_closed();
  if (absent && was_absent_) is_owner_ = false;
  was_absent_ = absent;
}

}  // namespace fanlight
