// SPDX-License-Identifier: Apache-2.0
#include "renderer/device_disposal.hpp"

#include <pthread.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>

namespace fanlight {

struct DeviceDisposal::State {
  std::mutex mutex;
  std::condition_variable changed;
  int pending = 0;
};

DeviceDisposal::DeviceDisposal() : state_(std::make_shared<State>()) {}

void DeviceDisposal::take(DeviceRenderer renderer) {
  if (renderer.renderer == nullptr) return;
  renderer.renderer->give_up();
  {
    const std::scoped_lock lock(state_->mutex);
    ++state_->pending;
  }
  std::thread([state = state_, disposed = std::move(renderer)]() mutable {
    pthread_setname_np(pthread_self(), "gpu disposal");
    disposed.renderer->devices().wait_for_end();
    disposed.reset();
    const std::scoped_lock lock(state->mutex);
    --state->pending;
    state->changed.notify_all();
  }).detach();
}

bool DeviceDisposal::wait(std::int64_t timeout_ns) const {
  std::unique_lock lock(state_->mutex);
  return state_->changed.wait_for(lock, std::chrono::nanoseconds(timeout_ns),
                                  [this] { return state_->pending == 0; });
}

}  // namespace fanlight
