// SPDX-License-Identifier: Apache-2.0
// Renderer: a GPU that is lost, hangs, or has no memory; and the end.
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "proto/base/clock.hpp"
#include "renderer/renderer.hpp"

namespace fanlight {

namespace {

// A driver of a GPU resets it after a few seconds by itself, and then says so. A processor that renders has
// no such limit, shares its time with everything else on the machine, and compiles shaders within a
// submission.
constexpr std::int64_t kProcessorHungNs = 30'000'000'000;
constexpr std::int64_t kSettlePollNs = 10'000'000;

}  // namespace

Watchdog::Limits Renderer::default_limits(const Gpu& gpu) {
  Watchdog::Limits limits;
  if (gpu.candidate().kind == kProcessorKind) limits.least_hung_ns = kProcessorHungNs;
  return limits;
}

Renderer::~Renderer() {
  if (!given_up_) {
    const bool settled = settle(watchdog_.hung_after_ns());
    if (!settled && gpu_.condition() == Gpu::Condition::kSound)
      gpu_.note_fault(Gpu::Condition::kHung,
                      {ErrorCode::kLost, "the GPU did not finish its work at the end"});
    if (settled) pipelines_->save_cache();
    give_up();
  }
  if (gpu_.condition() != Gpu::Condition::kHung) return;
  // The GPU may still write to this memory, so it is left to the end of the process.
  for (auto& state : slots_) static_cast<void>(state.release());
  private_.leave_memory();
  static_cast<void>(pipelines_.release());
}

void Renderer::give_up() {
  if (std::exchange(given_up_, true)) return;
  for (const auto& state : slots_) {
    if (!state) continue;
    if (state->awaits_picture) counters_.volumes_skipped.add();
    if (state->phase == WorkPhase::kLighting && gpu_.fault() != nullptr) counters_.pictures_lost.add();
  }
}

bool Renderer::settle(std::int64_t timeout_ns) {
  for (const auto& state : slots_) {
    if (state) state->slot.drop_held();
  }
  private_.drop_held();
  const std::int64_t deadline_ns = now_ns() + timeout_ns;
  while (gpu_.fault() == nullptr) {
    const bool outstanding =
        private_.outstanding_view() != nullptr || std::ranges::any_of(slots_, [this](const auto& state) {
          return state && state->slot.outstanding(gpu_) > 0;
        });
    const std::int64_t left_ns = deadline_ns - now_ns();
    if (!outstanding) return gpu_.fault() == nullptr;
    if (left_ns <= 0 || !wait(std::min(left_ns, kSettlePollNs))) return false;
  }
  return false;
}

bool Renderer::falls_back(const Error& error) {
  const bool other = scene_.revision != proven_.revision || scene_.deadline != proven_.deadline;
  if (error.code == ErrorCode::kLost || !other) return false;
  scene_refusal_ = fmt::format("the scene of revision {} is not shown: {}", scene_.revision, error.message);
  scene_refused_ns_ = now_ns();
  scene_ = proven_;
  return true;
}

void Renderer::try_refused_scene() {
  const auto try_ns = next_scene_try_ns();
  if (!try_ns || now_ns() < *try_ns) return;
  scene_ = wanted_;
  scene_rest_ns_ = std::min(2 * scene_rest_ns_, kMostSceneRestNs);
}

Result<void> Renderer::retry_held() {
  for (const auto& state : slots_) {
    if (auto retried = state->slot.retry_held(); !retried) return retried;
  }
  return private_.retry_held();
}

Result<void> Renderer::observe() {
  std::array<Watchdog::Lane, 2 + kMostPrivateViews> lanes;
  static_assert(lanes.size() <= Watchdog::kMostLanes);
  const auto lane_of = [this](const SubmissionTimeline& timeline) {
    return Watchdog::Lane{.submissions = timeline.submissions(),
                          .outstanding = timeline.outstanding(gpu_) > 0};
  };
  for (std::size_t slot = 0; slot < slots_.size(); ++slot)
    lanes[slot] = lane_of(slots_[slot]->slot.view().timeline());
  for (std::size_t view = 0; view < kMostPrivateViews; ++view) {
    const SubmissionTimeline* const timeline = private_.timeline(view);
    if (timeline != nullptr) lanes[slots_.size() + view] = lane_of(*timeline);
  }
  pace_ = watchdog_.observe(lanes, now_ns());
  if (pace_ == Watchdog::Pace::kHung) {
    const double limit_s = static_cast<double>(watchdog_.hung_after_ns()) / 1e9;
    gpu_.note_fault(
        Gpu::Condition::kHung,
        {ErrorCode::kLost, fmt::format("the GPU has not finished a submission for {:.0f} s, expected it "
                                       "within a few times the longest before",
                                       limit_s)});
  }
  return gpu_.fault() == nullptr ? Result<void>{} : *gpu_.fault();
}

}  // namespace fanlight
