#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

#include "proto/result.hpp"

namespace fanlight::test {

/// A command that runs beside this process, with its environment.
class ChildProcess {
 public:
  /// Keeps SIGINT, SIGTERM and SIGCHLD for wait(); to be called before the first thread is made.
  static void keep_signals();

  /// kNotFound where the command cannot be started.
  static Result<ChildProcess> start(const std::vector<std::string>& command);

  /// Waits for its end and returns its exit status, 128 + the number of the signal that ended it. Passes
  /// SIGINT and SIGTERM on, and asks it to end (SIGTERM) after `seconds`.
  int wait(std::optional<double> seconds);

 private:
  explicit ChildProcess(pid_t id) : id_(id) {}

  std::optional<int> status();

  pid_t id_;
};

}  // namespace fanlight::test
