// SPDX-License-Identifier: Apache-2.0
// RenderThread: a new device after a loss, and the end of the thread.
#include <fmt/format.h>

#include <algorithm>

#include "proto/base/clock.hpp"
#include "renderer/render_thread.hpp"

namespace fanlight {

namespace {

using State = RenderHealth::State;

// A device that only lacks memory, or failed in one call, may finish its work before it is destroyed.
constexpr std::int64_t kSettleNs = 200'000'000;
// The memory of the old device is wanted for the new one, but not waited for longer than this.
constexpr std::int64_t kDisposalNs = 1'000'000'000;
// A driver that resets its GPU refuses new devices for some seconds.
constexpr std::int64_t kRemakeNs = 10'000'000'000;
constexpr std::int64_t kRemakePauseNs = 250'000'000;

}  // namespace

bool RenderThread::recover(const Error& cause, const std::stop_token& stop) {
  to_.counters.devices_lost.add();
  health_.count_loss();
  const Renderer::Progress progress = renderer().progress();
  const NumberedScene proven = renderer().proven_scene();
  dispose(cause);
  if (!to_.remake) {
    fail(cause);
    return false;
  }
  if (losses_.lost(now_ns())) {
    fail(
        {ErrorCode::kLost, fmt::format("the GPU was lost {} times in a short time, the last time because {}; "
                                       "expected a GPU that goes on working",
                                       LossRecord::kMost, cause.message)});
    return false;
  }
  disposal_.wait(kDisposalNs);
  health_.set_state(State::kRemaking, cause.message, now_ns());
  if (!remake(proven, stop)) return false;
  renderer().resume(progress);
  show_degraded();
  volume_due_ = views_due_ = true;
  was_busy_ = false;
  return true;
}

void RenderThread::dispose(const Error& cause) {
  if (cause.code == ErrorCode::kLost) renderer().note_fault(Gpu::Condition::kLost, cause);
  if (renderer().condition() == Gpu::Condition::kSound && !renderer().settle(kSettleNs))
    renderer().note_fault(Gpu::Condition::kHung, cause);
  const bool hung = renderer().condition() == Gpu::Condition::kHung;
  health_.set_state(hung ? State::kHung : State::kRemaking, cause.message, now_ns());
  disposal_.take(std::move(device_));
}

bool RenderThread::remake(const NumberedScene& scene, const std::stop_token& stop) {
  const std::int64_t deadline_ns = now_ns() + kRemakeNs;
  while (!stop.stop_requested()) {
    to_.counters.turn_began_ns.set(now_ns());
    auto made = to_.remake(scene);
    if (made) {
      device_ = std::move(*made);
      return true;
    }
    if (now_ns() > deadline_ns) {
      fail({ErrorCode::kLost,
            fmt::format("the GPU was lost and could not be opened again: {}", made.error().message)});
      return false;
    }
    pause(now_ns() + kRemakePauseNs, stop);
  }
  return false;
}

void RenderThread::pause(std::int64_t until_ns, const std::stop_token& stop) const {
  // The bell rings for volumes and frames as well.
  while (!stop.stop_requested() && now_ns() < until_ns)
    to_.link.to_renderer.wait(std::max<std::int64_t>(until_ns - now_ns(), 1));
}

void RenderThread::fail(const Error& error) {
  to_.link.answer(error);
}

void RenderThread::retire() {
  to_.counters.turn_began_ns.set(0);
  volume_ = {};
  cine_.end();
  if (device_.renderer == nullptr) return;
  if (renderer().settle(settle_ns_)) {
    device_.reset();
    return;
  }
  renderer().note_fault(Gpu::Condition::kHung,
                        {ErrorCode::kLost, "the GPU did not finish its work at the end"});
  disposal_.take(std::move(device_));
}

bool RenderThread::end(std::int64_t timeout_ns) {
  if (thread_.joinable()) {
    // The other half is for what the thread does besides waiting for the GPU.
    settle_ns_ = timeout_ns / 2;
    thread_.request_stop();
    to_.link.to_renderer.ring();
    if (!ended_.wait(timeout_ns)) return false;
    thread_.join();
  }
  return disposal_.idle();
}

RenderThread::~RenderThread() {
  thread_.request_stop();
  to_.link.to_renderer.ring();
}

}  // namespace fanlight
