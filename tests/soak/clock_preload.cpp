// SPDX-License-Identifier: Apache-2.0
// A library for LD_PRELOAD: the calendar clock of the process is off by the seconds that the file
// FANLIGHT_CLOCK_FILE names, which is read again a few times a second. The steady clock is not touched, as by
// somebody who sets the clock.
#include <dlfcn.h>
#include <sys/time.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <string>
#include <thread>

namespace {

std::atomic<long> offset_s{0};

void follow(const std::string& path) {
  for (;;) {
    long seconds = 0;
    std::ifstream(path) >> seconds;
    offset_s = seconds;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
}

[[gnu::constructor]] void begin() {
  if (const char* const path = std::getenv("FANLIGHT_CLOCK_FILE"))
    std::thread(follow, std::string(path)).detach();
}

}  // namespace

extern "C" {

int clock_gettime(clockid_t clock, timespec* time) {
  static const auto next = reinterpret_cast<int (*)(clockid_t, timespec*)>(dlsym(RTLD_NEXT, "clock_gettime"));
  const int result = next(clock, time);
  if (clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_COARSE) time->tv_sec += offset_s;
  return result;
}

int gettimeofday(timeval* time, void* zone) {
  static const auto next = reinterpret_cast<int (*)(timeval*, void*)>(dlsym(RTLD_NEXT, "gettimeofday"));
  const int result = next(time, zone);
  time->tv_sec += offset_s;
  return result;
}

std::time_t time(std::time_t* to) {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  if (to != nullptr) *to = now.tv_sec;
  return now.tv_sec;
}

}  // extern "C"
