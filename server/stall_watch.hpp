#pragma once

#include <cstdint>

namespace fanlight {

/// Whether the other end of a TCP connection takes what it is sent.
class StallWatch {
 public:
  /// Once a second: how many seconds nothing has been acknowledged though something waits to be. `writing`:
  /// there is more than the kernel has taken.
  int seconds_stalled(int socket, bool writing);

 private:
  std::uint64_t acknowledged_ = 0;
  int seconds_ = 0;
};

}  // namespace fanlight
