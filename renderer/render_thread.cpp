// SPDX-License-Identifier: Apache-2.0
#include "renderer/render_thread.hpp"

#include <pthread.h>

#include <algorithm>

#include "proto/base/clock.hpp"

namespace fanlight {

namespace {

// While the GPU works, the thread waits for it, and looks for a new scene or volume at this interval.
constexpr std::int64_t kPollNs = 2'000'000;
// Window over which the main view's busy share is measured.
constexpr std::int64_t kWindowNs = 1'000'000'000;

}  // namespace

RenderThread::RenderThread(std::unique_ptr<Renderer> renderer, const Dependencies& dependencies)
    : renderer_(std::move(renderer)),
      to_(dependencies),
      requested_(renderer_->scene()),
      finest_mm_(renderer_->config().geometry.finest_mm()),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

RenderThread::~RenderThread() {
  thread_.request_stop();
  to_.bell.ring();
}

void RenderThread::run(const std::stop_token& stop) {
  pthread_setname_np(pthread_self(), "render");
  governor_.scene_came(requested_.scene, now_ns());
  while (!stop.stop_requested()) {
    if (const auto done = step(); !done) {
      to_.failures.draft() = done.error();
      to_.failures.publish();
      return;
    }
  }
}

void RenderThread::take_scene() {
  if (const NumberedScene* newest = to_.scenes.newest()) {
    requested_ = *newest;
    governor_.scene_came(requested_.scene, now_ns());
    renderer_->show(requested_);
  }
  if (governor_.in_force(now_ns()) != renderer_->scene().deadline) show_degraded();
}

void RenderThread::show_degraded() {
  const DeadlineState state = governor_.in_force(now_ns());
  renderer_->show({.revision = requested_.revision,
                   .scene = degraded(requested_.scene, state.measures, finest_mm_),
                   .deadline = state});
}

void RenderThread::rest() {
  const std::int64_t now = now_ns();
  if (governor_.in_force(now) != renderer_->scene().deadline) return;  // it has just changed
  const auto change_ns = governor_.next_change_ns(now);
  to_.bell.wait(change_ns ? std::max<std::int64_t>(*change_ns - now, 0) : -1);
}

Result<void> RenderThread::step() {
  take_scene();
  if (auto taken = take_volume(); !taken) return taken;
  take_frames();
  if (auto taken = take_private_views(); !taken) return taken;
  if (auto advanced = renderer_->advance(); !advanced) return advanced;
  if (renderer_->collect(to_.pictures.draft())) {
    governor_.picture_finished(to_.pictures.draft().stamp);
    if (to_.pictures.publish()) to_.counters.pictures_replaced.add();
    return {};  // its slot is free now: look for work before waiting
  }
  if (renderer_->collect_private()) return {};
  measure_busy();
  // One observation decides between waiting for the GPU, more private work, and rest: work that ends between
  // two observations would stay uncollected until the next ring of the bell.
  if (renderer_->busy()) return renderer_->wait(kPollNs);
  if (!to_.ring.has_published()) {
    const auto advanced = renderer_->advance_private();
    if (!advanced) return advanced.error();
    if (*advanced) return {};
  }
  rest();
  return {};
}

void RenderThread::measure_busy() {
  const std::int64_t now = now_ns();
  if (was_busy_) busy_ns_ += now - measured_ns_;
  was_busy_ = renderer_->main_busy();
  measured_ns_ = now;
  if (window_ns_ == 0) window_ns_ = now;
  if (now - window_ns_ < kWindowNs) return;
  to_.counters.main_busy_share.set(static_cast<double>(busy_ns_) / static_cast<double>(now - window_ns_));
  window_ns_ = now;
  busy_ns_ = 0;
}

Result<void> RenderThread::take_volume() {
  if (!renderer_->wants_volume()) return {};
  const auto volume = to_.ring.take();
  if (!volume) return {};
  if (finest_mm_ != volume->geometry().finest_mm()) {
    finest_mm_ = volume->geometry().finest_mm();
    show_degraded();
  }
  return renderer_->load(*volume);
}

Result<void> RenderThread::take_private_views() {
  const PrivateViews* const views = to_.private_views == nullptr ? nullptr : to_.private_views->newest();
  return views == nullptr ? Result<void>{} : renderer_->want(*views);
}

void RenderThread::take_frames() {
  if (to_.feed == nullptr) return;
  // A published volume goes first: the queued frames belong to a volume after it.
  while (!to_.ring.has_published() && renderer_->wants_frame()) {
    const QueuedFrame* const frame = to_.feed->front();
    if (frame == nullptr) return;
    renderer_->take_frame(*frame);
    to_.feed->pop();
  }
}

}  // namespace fanlight
