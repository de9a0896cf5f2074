#pragma once

#include <sys/types.h>

#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

namespace fanlight::test {

/// A gadget_probe that runs beside this process, and takes its orders. One thread.
class GadgetProcess {
 public:
  /// Starts it, plugged in. Throws std::runtime_error where it cannot be; it has said why.
  GadgetProcess(const std::string& program, const std::vector<std::string>& options);
  /// Ends it, which unplugs it.
  ~GadgetProcess();
  GadgetProcess(const GadgetProcess&) = delete;
  GadgetProcess& operator=(const GadgetProcess&) = delete;

  /// The answer to a line of gadget_probe_command.cpp. Throws where there is none.
  std::string ask(const std::string& line);
  /// Lets a fault happen, and returns when (proto/clock.hpp).
  std::int64_t inject(const std::string& fault) { return std::stoll(ask(fault)); }
  /// When it was plugged in at its start.
  std::int64_t plugged_ns() const { return plugged_ns_; }

 private:
  std::string answer();

  pid_t id_ = -1;
  std::FILE* orders_ = nullptr;
  std::FILE* answers_ = nullptr;
  std::int64_t plugged_ns_ = 0;
};

}  // namespace fanlight::test
