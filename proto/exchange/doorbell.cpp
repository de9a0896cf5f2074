// SPDX-License-Identifier: Apache-2.0
#include "proto/exchange/doorbell.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>

#include "proto/exchange/pulse.hpp"

namespace fanlight {

Doorbell::Doorbell() : fd_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  if (fd_ < 0) {
    // Only at start, when the process has no free file descriptor: nothing can run without it.
    std::perror("fanlight: no event descriptor is to be had");
    std::abort();
  }
}

Doorbell::~Doorbell() {
  close(fd_);
}

void Doorbell::ring() {
  const std::uint64_t one = 1;
  // Fails only when the event counter is at its limit; the bell is then already ringing.
  [[maybe_unused]] const auto written = write(fd_, &one, sizeof one);
}

bool Doorbell::wait(std::int64_t timeout_ns) {
  constexpr std::int64_t kNsPerS = 1'000'000'000;
  while (timeout_ns != 0) {
    // In slices, so that a watchdog sees that the thread waits and does not hang.
    const std::int64_t slice_ns = timeout_ns < 0 ? kNsPerS : std::min(timeout_ns, kNsPerS);
    pollfd watched{.fd = fd_, .events = POLLIN, .revents = 0};
    const timespec slice{.tv_sec = slice_ns / kNsPerS, .tv_nsec = slice_ns % kNsPerS};
    const int ready = ppoll(&watched, 1, &slice, nullptr);
    Pulse::beat();
    if (ready != 0) break;
    if (timeout_ns > 0) timeout_ns -= slice_ns;
  }
  std::uint64_t rings = 0;
  return read(fd_, &rings, sizeof rings) == sizeof rings;
}

}  // namespace fanlight
