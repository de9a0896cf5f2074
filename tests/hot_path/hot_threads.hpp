// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <cstdint>

namespace fanlight::test {

/// Makes a thread hot while the object exists. `thread`: its id (gettid). If our code allocates, locks or
/// logs on a hot thread, the process prints the call and its stack, and aborts. Any thread may create and
/// destroy it. At most four threads are hot at the same time; one more aborts.
class HotThread {
 public:
  explicit HotThread(pid_t thread);
  ~HotThread();
  HotThread(const HotThread&) = delete;
  HotThread& operator=(const HotThread&) = delete;

 private:
  pid_t thread_;
};

/// Number of allocations, locks and writes of hot threads inside the graphics driver so far. They are
/// permitted (origin_of()).
std::uint64_t calls_within_driver();

/// Every interposed function calls this first, with its name and its return address. Does nothing on a cold
/// thread.
void check_call(const char* call, const void* caller);

}  // namespace fanlight::test
