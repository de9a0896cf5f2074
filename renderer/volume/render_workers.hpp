// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <stop_token>
#include <thread>
#include <type_traits>
#include <vector>

#include "proto/exchange/doorbell.hpp"

namespace fanlight {

/// Threads that share the work of the render thread: the frames of a volume, or the tiles of a picture. They
/// sleep between two calls.
class RenderWorkers {
 public:
  /// `threads`: that work at the same time, with the caller of run(). Where the system has no more, there are
  /// fewer.
  explicit RenderWorkers(std::size_t threads = usual_threads());
  RenderWorkers(const RenderWorkers&) = delete;
  RenderWorkers& operator=(const RenderWorkers&) = delete;

  /// One for each processor, up to 16.
  static std::size_t usual_threads();

  std::size_t threads() const { return workers_.size() + 1; }

  /// Calls task(thread, index) for each index below `count`, each once; `thread` is below threads(), and no
  /// two calls at the same time have the same. Returns when all calls have. `task` must not throw. Does not
  /// allocate or lock.
  template <typename Task>
  void run(std::size_t count, Task&& task) {
    call_ = [](void* of, std::size_t thread, std::size_t index) {
      (*static_cast<std::remove_reference_t<Task>*>(of))(thread, index);
    };
    task_ = &task;
    run(count);
  }

 private:
  struct Worker {
    Doorbell begin;
    std::jthread thread;
  };
  void run(std::size_t count);
  void work(std::size_t thread);
  void serve(Doorbell& begin, std::size_t thread, const std::stop_token& stop);

  // Of the call under way: written before the bells ring.
  void (*call_)(void* task, std::size_t thread, std::size_t index) = nullptr;
  void* task_ = nullptr;
  std::size_t count_ = 0;
  std::atomic<std::size_t> next_ = 0;
  std::atomic<std::size_t> at_work_ = 0;
  Doorbell ended_;
  std::vector<std::unique_ptr<Worker>> workers_;  // last: they use the other members until they are joined
};

}  // namespace fanlight
