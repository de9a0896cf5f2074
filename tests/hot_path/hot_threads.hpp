#pragma once

#include <sys/types.h>

#include <cstdint>

namespace fanlight::test {

/// While it lives, the thread of that id (gettid) is hot: where our code allocates, locks or logs on it, the
/// process says which call it was and from where, and aborts. Any thread may make it hot, or cold again; a
/// few can be hot at once.
class HotThread {
 public:
  explicit HotThread(pid_t thread);
  ~HotThread();
  HotThread(const HotThread&) = delete;
  HotThread& operator=(const HotThread&) = delete;

 private:
  pid_t thread_;
};

/// How often hot threads allocated, locked or wrote within the graphics driver so far, which is let be: see
/// origin_of().
std::uint64_t calls_within_driver();

/// What every interposed function calls before it does its work, with its name and its return address.
/// Nothing on a cold thread.
void look_at(const char* call, const void* caller);

}  // namespace fanlight::test
