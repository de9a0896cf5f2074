// SPDX-License-Identifier: Apache-2.0
#include "tests/hot_path/hot_threads.hpp"

#include <fmt/format.h>
#include <pthread.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdio>
#include <cstdlib>

#include "proto/base/counter.hpp"
#include "tests/hot_path/call_origin.hpp"

namespace fanlight::test {

namespace {

// Interposed functions are called before any constructor has run, so all of this is initialised statically.
constinit std::array<std::atomic<pid_t>, 4> hot_threads{};  // 0: free entry
constinit std::atomic<int> hot_count{0};
constinit Counter driver_calls;
constinit thread_local bool checking = false;  // inside the hook: its own calls are not checked

bool is_hot(pid_t thread) {
  return std::ranges::any_of(hot_threads, [thread](const auto& hot) { return hot.load() == thread; });
}

[[noreturn]] void report(const char* call, const void* caller) {
  std::array<char, 16> name{};
  pthread_getname_np(pthread_self(), name.data(), name.size());
  fmt::print(stderr, "hot path: {} on the hot thread {} (\"{}\"), called from\n", call, gettid(),
             name.data());
  for (const std::string& frame : stack_from(caller)) fmt::print(stderr, "  {}\n", frame);
  std::fflush(stderr);
  std::abort();
}

}  // namespace

HotThread::HotThread(pid_t thread) : thread_(thread) {
  for (auto& entry : hot_threads) {
    pid_t free = 0;
    if (!entry.compare_exchange_strong(free, thread)) continue;
    ++hot_count;
    return;
  }
  std::abort();  // more hot threads than entries
}

HotThread::~HotThread() {
  --hot_count;
  for (auto& entry : hot_threads) {
    pid_t mine = thread_;
    if (entry.compare_exchange_strong(mine, 0)) return;
  }
}

std::uint64_t calls_within_driver() {
  return driver_calls.value();
}

void check_call(const char* call, const void* caller) {
  if (hot_count.load(std::memory_order_relaxed) == 0 || checking || !is_hot(gettid())) return;
  checking = true;
  if (origin_of(caller) == Origin::kOurs) report(call, caller);
  driver_calls.add();
  checking = false;
}

}  // namespace fanlight::test
