// SPDX-License-Identifier: Apache-2.0
#include "renderer/volume/frame_workers.hpp"

#include <pthread.h>

#include <algorithm>

namespace fanlight {

std::size_t FrameWorkers::usual_threads() {
  // More would wait for memory, and a frame is the smallest part.
  constexpr std::size_t kMost = 8;
  return std::clamp<std::size_t>(std::thread::hardware_concurrency(), 1, kMost);
}

FrameWorkers::FrameWorkers(std::size_t threads) {
  for (std::size_t thread = 1; thread < threads; ++thread) {
    Worker& worker = *workers_.emplace_back(std::make_unique<Worker>());
    worker.thread =
        std::jthread([this, &worker, thread](const std::stop_token& stop) { serve(worker, thread, stop); });
  }
}

FrameWorkers::~FrameWorkers() {
  for (const auto& worker : workers_) {
    worker->thread.request_stop();
    worker->begin.ring();
  }
  workers_.clear();  // joins them, before what they use is destroyed
}

void FrameWorkers::run(std::size_t count) {
  count_ = count;
  next_ = 0;
  const std::size_t helpers = std::min(workers_.size(), count > 0 ? count - 1 : 0);
  at_work_ = helpers;
  for (std::size_t helper = 0; helper < helpers; ++helper) workers_[helper]->begin.ring();
  work(0);
  while (at_work_ > 0) ended_.wait(-1);
}

void FrameWorkers::work(std::size_t thread) {
  for (std::size_t index = next_++; index < count_; index = next_++) call_(task_, thread, index);
}

void FrameWorkers::serve(Worker& worker, std::size_t thread, const std::stop_token& stop) {
  pthread_setname_np(pthread_self(), "prepare");
  for (;;) {
    worker.begin.wait(-1);
    if (stop.stop_requested()) return;
    work(thread);
    if (--at_work_ == 0) ended_.ring();
  }
}

}  // namespace fanlight
