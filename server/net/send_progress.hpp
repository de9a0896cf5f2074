// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace fanlight {

/// Detects that the peer of a TCP connection does not acknowledge what it is sent.
class SendProgress {
 public:
  /// Call this once a second. Returns for how many seconds nothing was acknowledged although data was
  /// waiting. `writing`: there is more data than the kernel has accepted.
  int seconds_stalled(int socket, bool writing);

 private:
  std::uint64_t acknowledged_ = 0;
  int seconds_ = 0;
};

}  // namespace fanlight
