// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace fanlight {

/// Wakes the one thread that waits on it; the rings and mailboxes of that thread ring it. Rings before a wait
/// are remembered and merge into one. Implemented by a Linux eventfd, so that an event loop can watch it too.
class Doorbell {
 public:
  Doorbell();
  ~Doorbell();
  Doorbell(const Doorbell&) = delete;
  Doorbell& operator=(const Doorbell&) = delete;

  /// Any thread. Does not block, allocate or lock.
  void ring();

  /// Owning thread: blocks until the bell rings, at most timeout_ns. True if it rang since the last wait.
  /// Timeout 0 polls; a negative one waits without limit.
  bool wait(std::int64_t timeout_ns);

  /// For an event loop: readable while the bell rings. The loop clears it by wait(0).
  int file_descriptor() const { return fd_; }

 private:
  int fd_;
};

}  // namespace fanlight
