// SPDX-License-Identifier: Apache-2.0
// Renderer: a GPU that is lost, hangs, or has no memory; and the end.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <new>

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

const Error* Renderer::fault() const {
  // A fault of one device is one of both. The other one may still work on what was submitted, so its objects
  // are left as those of a device that hangs, until it has finished.
  if (gpu_.fault() != nullptr) light_gpu_.note_fault(Gpu::Condition::kHung, *gpu_.fault());
  if (light_gpu_.fault() != nullptr) gpu_.note_fault(Gpu::Condition::kHung, *light_gpu_.fault());
  return gpu_.fault();
}

Gpu::Condition Renderer::condition() const {
  using enum Gpu::Condition;
  static_cast<void>(fault());
  // Where one is lost, the other one is no reason to say that the GPU hangs.
  const bool lost = either_lost_ || gpu_.condition() == kLost || light_gpu_.condition() == kLost;
  return lost ? kLost : gpu_.condition();
}

void Renderer::note_fault(Gpu::Condition condition, const Error& error) const {
  // Which of two devices is lost is not known here, and the other one may be at work: both are waited for.
  either_lost_ |= condition == Gpu::Condition::kLost;
  gpu_.note_fault(on_one_device() ? condition : Gpu::Condition::kHung, error);
  static_cast<void>(fault());
}

void Renderer::wait_for_end() const {
  for (const Gpu* const gpu : {&gpu_, &light_gpu_}) {
    if (gpu->condition() == Gpu::Condition::kHung) gpu->wait_for_end();
  }
}

Renderer::~Renderer() {
  if (!given_up_) {
    const bool settled = settle(watchdog_.hung_after_ns());
    if (!settled && condition() == Gpu::Condition::kSound)
      note_fault(Gpu::Condition::kHung, {ErrorCode::kLost, "the GPU did not finish its work at the end"});
    if (settled) pipelines_->save_cache();
    give_up();
  }
  const bool at_work =
      gpu_.condition() == Gpu::Condition::kHung || light_gpu_.condition() == Gpu::Condition::kHung;
  if (!at_work) return;
  // The GPU may still write to this memory, so it is left to the end of the process.
  for (auto& state : slots_) static_cast<void>(state.release());
  private_.leave_memory();
  // A reference that is never dropped: a store may hold the pipelines too.
  static_cast<void>(new (std::nothrow) std::array{pipelines_, light_pipelines_});
}

void Renderer::give_up() {
  if (std::exchange(given_up_, true)) return;
  for (const auto& state : slots_) {
    if (!state) continue;
    if (state->awaits_picture) counters_.volumes_skipped.add();
    if (state->phase == WorkPhase::kLighting && fault() != nullptr) counters_.pictures_lost.add();
  }
}

bool Renderer::settle(std::int64_t timeout_ns) {
  for (const auto& state : slots_) {
    if (state) state->slot.drop_held();
  }
  private_.drop_held();
  const std::int64_t deadline_ns = now_ns() + timeout_ns;
  while (fault() == nullptr) {
    const bool outstanding =
        private_.outstanding_timeline() != nullptr ||
        std::ranges::any_of(slots_, [](const auto& state) { return state && state->slot.outstanding() > 0; });
    const std::int64_t left_ns = deadline_ns - now_ns();
    if (!outstanding) return fault() == nullptr;
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
  std::array<Watchdog::Lane, 4 + 2 * kMostPrivateViews> lanes;
  static_assert(lanes.size() <= Watchdog::kMostLanes);
  std::size_t next = 0;
  const auto add = [&](const SubmissionTimeline* timeline) {
    Watchdog::Lane& lane = lanes[next++];
    if (timeline != nullptr)
      lane = {.submissions = timeline->submissions(), .outstanding = timeline->outstanding() > 0};
  };
  for (const auto& state : slots_) {
    add(&state->slot.cast_timeline());
    add(&state->slot.light_timeline());
  }
  for (std::size_t view = 0; view < kMostPrivateViews; ++view) {
    for (const SubmissionTimeline* const timeline : private_.timelines(view)) add(timeline);
  }
  pace_ = watchdog_.observe(lanes, now_ns());
  if (pace_ == Watchdog::Pace::kHung) {
    const double limit_s = static_cast<double>(watchdog_.hung_after_ns()) / 1e9;
    note_fault(
        Gpu::Condition::kHung,
        {ErrorCode::kLost, fmt::format("the GPU has not finished a submission for {:.0f} s, expected it "
                                       "within a few times the longest before",
                                       limit_s)});
  }
  const Error* const known = fault();
  return known == nullptr ? Result<void>{} : *known;
}

}  // namespace fanlight
