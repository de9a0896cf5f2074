// SPDX-License-Identifier: Apache-2.0
#include "renderer/replaceable_renderer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "proto/base/clock.hpp"

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

bool ReplaceableRenderer::replace(const Error& cause, const std::stop_token& stop) {
  to_.counters.devices_lost.add();
  to_.health.count_loss();
  const Renderer::Progress progress = device_.renderer->progress();
  const NumberedScene proven = device_.renderer->scenes().proven();
  dispose(cause);
  if (!to_.remake) {
    fail(cause);
    return false;
  }
  if (losses_.lost(now_ns())) {
    fail(
        {ErrorCode::kLost, fmt::format("the GPU was lost {} times in a short time, the last time because {}; "
                                       "expected a GPU that keeps working",
                                       LossRecord::kMost, cause.message)});
    return false;
  }
  disposal_.wait(kDisposalNs);
  to_.health.set_state(State::kRemaking, cause.message, now_ns());
  if (!remake(proven, stop)) return false;
  device_.renderer->resume(progress);
  return true;
}

void ReplaceableRenderer::dispose(const Error& cause) {
  Renderer& renderer = *device_.renderer;
  if (cause.code == ErrorCode::kLost) renderer.devices().note_fault(Gpu::Condition::kLost, cause);
  if (renderer.devices().condition() == Gpu::Condition::kSound && !renderer.settle(kSettleNs))
    renderer.devices().note_fault(Gpu::Condition::kHung, cause);
  const bool hung = renderer.devices().condition() == Gpu::Condition::kHung;
  to_.health.set_state(hung ? State::kHung : State::kRemaking, cause.message, now_ns());
  disposal_.take(std::move(device_));
}

bool ReplaceableRenderer::remake(const NumberedScene& scene, const std::stop_token& stop) {
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

void ReplaceableRenderer::pause(std::int64_t until_ns, const std::stop_token& stop) const {
  // The bell rings for volumes and frames as well.
  while (!stop.stop_requested() && now_ns() < until_ns)
    to_.link.to_renderer.wait(std::max<std::int64_t>(until_ns - now_ns(), 1));
}

void ReplaceableRenderer::end(std::int64_t settle_ns) {
  if (device_.renderer == nullptr) return;
  if (device_.renderer->settle(settle_ns)) {
    device_.reset();
    return;
  }
  device_.renderer->devices().note_fault(Gpu::Condition::kHung,
                                         {ErrorCode::kLost, "the GPU did not finish its work at the end"});
  disposal_.take(std::move(device_));
}

}  // namespace fanlight
