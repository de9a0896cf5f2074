// SPDX-License-Identifier: Apache-2.0
#include "server/codec/encoder_pool.hpp"

#include <pthread.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

namespace fanlight {

namespace {

struct LaneFacts {
  const char* name;
  int nice;  // of 19: below the renderer, and still a share of a busy processor
};
constexpr std::array<LaneFacts, kEncoderLanes> kLaneFacts = {
    {{"encode", 0}, {"encode heavy", 10}, {"encode slow", 15}, {"asked", 0}}};

}  // namespace

std::size_t EncoderPool::usual_threads() {
  return std::max<std::size_t>(1, std::thread::hardware_concurrency() / 4);
}

EncoderPool::EncoderPool(std::size_t threads) : lane_threads_(threads) {
  const auto start = [this](EncoderLane lane) {
    threads_.emplace_back([this, lane](const std::stop_token& stop) { run(stop, lane); });
  };
  start(EncoderLane::kAsked);
  for (std::size_t thread = 0; thread < threads; ++thread) {
    for (const EncoderLane lane : {EncoderLane::kQuick, EncoderLane::kHeavy, EncoderLane::kBackground})
      start(lane);
  }
}

EncoderPool::~EncoderPool() {
  for (std::jthread& thread : threads_) thread.request_stop();
}

void EncoderPool::submit(EncoderLane lane, Work work) {
  Queue& queue = queues_[static_cast<std::size_t>(lane)];
  {
    const std::lock_guard lock(mutex_);
    queue.works.push_back(std::move(work));
  }
  queue.wake.notify_one();
}

void EncoderPool::run(const std::stop_token& stop, EncoderLane lane) {
  const auto& [name, nice] = kLaneFacts[static_cast<std::size_t>(lane)];
  pthread_setname_np(pthread_self(), name);
  // On Linux the priority is the thread's, not the process's. A failure costs nothing but the preference.
  if (nice > 0) setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), nice);
  Queue& queue = queues_[static_cast<std::size_t>(lane)];
  for (;;) {
    Work work;
    {
      std::unique_lock lock(mutex_);
      if (!queue.wake.wait(lock, stop, [&queue] { return !queue.works.empty(); })) return;
      work = std::move(queue.works.front());
      queue.works.pop_front();
    }
    work();
  }
}

}  // namespace fanlight
