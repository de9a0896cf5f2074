// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

#include "proto/base/result.hpp"

namespace fanlight::test {

/// A command that runs as a child process, with this process's environment.
class ChildProcess {
 public:
  /// Blocks SIGINT, SIGTERM and SIGCHLD for wait(); must be called before the first thread is created.
  static void keep_signals();

  /// kNotFound where the command cannot be started.
  static Result<ChildProcess> start(const std::vector<std::string>& command);

  /// Waits for its end and returns its exit status, or 128 + the number of the signal that ended it. Forwards
  /// SIGINT and SIGTERM, and sends SIGTERM after `seconds`.
  int wait(std::optional<double> seconds);

 private:
  explicit ChildProcess(pid_t id) : id_(id) {}

  std::optional<int> status();

  pid_t id_;
};

}  // namespace fanlight::test
