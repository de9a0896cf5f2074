// SPDX-License-Identifier: Apache-2.0
#include "server/net/send_progress.hpp"

// The kernel's header has the byte counters of tcp_info, glibc's does not.
#include <linux/sockios.h>
#include <linux/tcp.h>
#include <netinet/in.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

namespace fanlight {

int SendProgress::seconds_stalled(int socket, bool writing) {
  tcp_info info{};
  socklen_t bytes = sizeof info;
  if (getsockopt(socket, IPPROTO_TCP, TCP_INFO, &info, &bytes) != 0) return 0;
  int unsent = 0;
  if (ioctl(socket, SIOCOUTQ, &unsent) != 0) unsent = 0;
  const bool waits = writing || unsent > 0;
  const bool moved = info.tcpi_bytes_acked != acknowledged_;
  acknowledged_ = info.tcpi_bytes_acked;
  seconds_ = waits && !moved ? seconds_ + 1 : 0;
  return seconds_;
}

}  // namespace fanlight
