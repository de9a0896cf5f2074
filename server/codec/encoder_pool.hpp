// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>
#include <vector>

namespace fanlight {

/// Whether an encoding delays the others: a PNG or a depth map takes ten times a JPEG, the scan conversion of
/// a volume a hundred times.
/// A survey (SurveyDesk) and a measurement of fluid (FluidDesk) are no encodings, but a user waits for them:
/// they have one thread, at the usual priority.
enum class EncoderLane : std::uint8_t { kQuick, kHeavy, kBackground, kAsked };
inline constexpr std::size_t kEncoderLanes = 4;

/// Runs `work` on a thread of the lane, and then `done` on the server thread.
using Executor =
    std::function<void(EncoderLane lane, std::function<void()> work, std::function<void()> done)>;

/// Threads that encode pictures, so that the event loop does not. Each lane has threads of its own; those of
/// the heavy and the background lane run at a low priority.
class EncoderPool {
 public:
  using Work = std::function<void()>;

  /// `threads`: of each lane but kAsked, 1 or more.
  explicit EncoderPool(std::size_t threads = usual_threads());
  /// Waits for the work that runs; the work that waits is dropped.
  ~EncoderPool();
  EncoderPool(const EncoderPool&) = delete;
  EncoderPool& operator=(const EncoderPool&) = delete;

  /// Runs `work` on a thread of the lane. Any thread. The caller bounds how much waits: no more than
  /// threads() a lane are ever useful.
  void submit(EncoderLane lane, Work work);

  std::size_t threads() const { return lane_threads_; }

  /// A quarter of the processors for each lane: the rest is the renderer's and the acquisition's.
  static std::size_t usual_threads();

 private:
  struct Queue {
    std::deque<Work> works;
    std::condition_variable_any wake;
  };
  void run(const std::stop_token& stop, EncoderLane lane);

  std::size_t lane_threads_;
  std::mutex mutex_;
  std::array<Queue, kEncoderLanes> queues_;
  std::vector<std::jthread> threads_;  // last: they use the others
};

}  // namespace fanlight
