// SPDX-License-Identifier: Apache-2.0
// For LD_PRELOAD: a thread whose name is in FANLIGHT_FREEZE_THREAD stands still at its next wait, once the
// file FANLIGHT_FREEZE_FILE is there. What a watchdog is for.
#include <dlfcn.h>
#include <poll.h>
#include <pthread.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <cstring>

namespace {

bool is_frozen() {
  const char* const file = std::getenv("FANLIGHT_FREEZE_FILE");
  const char* const thread = std::getenv("FANLIGHT_FREEZE_THREAD");
  char name[16] = {};
  return file != nullptr && thread != nullptr && pthread_getname_np(pthread_self(), name, sizeof name) == 0 &&
         std::strcmp(name, thread) == 0 && access(file, F_OK) == 0;
}

}  // namespace

// NOLINTNEXTLINE(readability-identifier-naming): the C library's
extern "C" int ppoll(pollfd* descriptors, nfds_t count, const timespec* timeout, const sigset_t* signals) {
  using Wait = int (*)(pollfd*, nfds_t, const timespec*, const sigset_t*);
  static const auto next = reinterpret_cast<Wait>(dlsym(RTLD_NEXT, "ppoll"));
  while (is_frozen()) usleep(100'000);
  return next(descriptors, count, timeout, signals);
}
