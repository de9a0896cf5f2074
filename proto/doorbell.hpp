#pragma once

#include <cstdint>

namespace fanlight {

/// Wakes the one thread that waits on it; the rings and mailboxes of that thread ring it. Rings before a
/// wait are remembered and merge into one. A Linux eventfd, so that an event loop can watch it as well.
class Doorbell {
 public:
  Doorbell();
  ~Doorbell();
  Doorbell(const Doorbell&) = delete;
  Doorbell& operator=(const Doorbell&) = delete;

  /// Any thread. Never blocks, allocates or locks.
  void ring();

  /// The owning thread: returns true as soon as it was rung since the last wait, false after timeout_ns.
  /// A timeout of 0 only asks; a negative one waits for ever.
  bool wait(std::int64_t timeout_ns);

  /// For an event loop: readable while rung. The loop calls wait(0) to clear it.
  int file_descriptor() const { return fd_; }

 private:
  int fd_;
};

}  // namespace fanlight
