// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

namespace fanlight::test {

/// A gadget_probe child process and its commands. One thread.
class GadgetProcess {
 public:
  /// Starts it, plugged in. Throws std::runtime_error on failure; the process has printed the reason.
  GadgetProcess(const std::string& program, const std::vector<std::string>& options);
  /// Ends it, which unplugs it.
  ~GadgetProcess();
  GadgetProcess(const GadgetProcess&) = delete;
  GadgetProcess& operator=(const GadgetProcess&) = delete;

  /// The answer to a line of gadget_probe_command.cpp. Throws where there is none.
  std::string ask(const std::string& line);
  /// Injects a fault and returns its time (proto/base/clock.hpp).
  std::int64_t inject(const std::string& fault) { return std::stoll(ask(fault)); }
  /// Time at which it was first plugged in.
  std::int64_t plugged_ns() const { return plugged_ns_; }

 private:
  std::string answer();

  pid_t id_ = -1;
  std::FILE* orders_ = nullptr;
  std::FILE* answers_ = nullptr;
  std::int64_t plugged_ns_ = 0;
};

}  // namespace fanlight::test
