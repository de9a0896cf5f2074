// SPDX-License-Identifier: Apache-2.0
#include "renderer/volume/render_workers.hpp"

#include <pthread.h>

#include <algorithm>
#include <system_error>
#include <utility>

#include "proto/base/low_priority.hpp"

namespace fanlight {

std::size_t RenderWorkers::usual_threads() {
  // More would wait for memory.
  constexpr std::size_t kMost = 16;
  return std::clamp<std::size_t>(std::thread::hardware_concurrency(), 1, kMost);
}

RenderWorkers::RenderWorkers(std::size_t threads) {
  workers_.reserve(threads);
  for (std::size_t thread = 1; thread < threads; ++thread) {
    auto worker = std::make_unique<Worker>();
    try {
      worker->thread = std::jthread([this, &begin = worker->begin, thread](const std::stop_token& stop) {
        serve(begin, thread, stop);
      });
    } catch (const std::system_error&) {
      return;  // fewer threads do the same work
    }
    workers_.push_back(std::move(worker));
  }
}

void RenderWorkers::run(std::size_t count) {
  count_ = count;
  next_ = 0;
  const std::size_t helpers = std::min(workers_.size(), count > 0 ? count - 1 : 0);
  at_work_ = helpers;
  for (std::size_t helper = 0; helper < helpers; ++helper) workers_[helper]->begin.ring();
  work(0);
  while (at_work_ > 0) ended_.wait(-1);
}

void RenderWorkers::work(std::size_t thread) {
  for (std::size_t index = next_++; index < count_; index = next_++) call_(task_, thread, index);
}

void RenderWorkers::serve(Doorbell& begin, std::size_t thread, const std::stop_token& stop) {
  pthread_setname_np(pthread_self(), "render work");
  lower_priority(kCastNiceness);
  const std::stop_callback wakes(stop, [&begin] { begin.ring(); });
  while (!stop.stop_requested()) {
    // A signal may end the wait without a ring.
    if (!begin.wait(-1) || stop.stop_requested()) continue;
    work(thread);
    if (--at_work_ == 0) ended_.ring();
  }
}

}  // namespace fanlight
