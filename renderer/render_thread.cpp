#include "renderer/render_thread.hpp"

#include <pthread.h>

#include <algorithm>

#include "proto/clock.hpp"

namespace fanlight {

namespace {

// While the GPU works the thread waits for it, and looks this often whether a scene or a volume has come.
constexpr std::int64_t kLookNs = 2'000'000;
// Over which the main view's share of the time is told.
constexpr std::int64_t kWindowNs = 1'000'000'000;

}  // namespace

RenderThread::RenderThread(std::unique_ptr<Renderer> renderer, const Dependencies& dependencies)
    : renderer_(std::move(renderer)),
      to_(dependencies),
      asked_(renderer_->scene()),
      finest_mm_(renderer_->config().geometry.finest_mm()),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

RenderThread::~RenderThread() {
  thread_.request_stop();
  to_.bell.ring();
}

void RenderThread::run(const std::stop_token& stop) {
  pthread_setname_np(pthread_self(), "render");
  deadline_.scene_came(asked_.scene, now_ns());
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
    asked_ = *newest;
    deadline_.scene_came(asked_.scene, now_ns());
    renderer_->show(asked_);
  }
  if (deadline_.in_force(now_ns()) != renderer_->scene().deadline) show_planned();
}

void RenderThread::show_planned() {
  const DeadlineState state = deadline_.in_force(now_ns());
  renderer_->show({.revision = asked_.revision,
                   .scene = planned(asked_.scene, state.measures, finest_mm_),
                   .deadline = state});
}

void RenderThread::rest() {
  const std::int64_t now = now_ns();
  if (deadline_.in_force(now) != renderer_->scene().deadline) return;  // it has just become another one
  const auto change_ns = deadline_.next_change_ns(now);
  to_.bell.wait(change_ns ? std::max<std::int64_t>(*change_ns - now, 0) : -1);
}

Result<void> RenderThread::step() {
  take_scene();
  if (auto taken = take_volume(); !taken) return taken;
  take_frames();
  if (auto taken = take_private_views(); !taken) return taken;
  if (auto advanced = renderer_->advance(); !advanced) return advanced;
  if (renderer_->collect(to_.pictures.draft())) {
    deadline_.picture_finished(to_.pictures.draft().stamp);
    if (to_.pictures.publish()) to_.counters.pictures_replaced.add();
    return {};  // its slot is free now: look for work before sleeping
  }
  // Nothing of the main view waits for what comes next.
  if (renderer_->collect_private()) return {};
  if (!renderer_->main_busy() && !to_.ring.has_published()) {
    if (auto advanced = renderer_->advance_private(); !advanced) return advanced;
  }
  note_busy();
  if (renderer_->busy()) return renderer_->wait(kLookNs);
  rest();
  return {};
}

void RenderThread::note_busy() {
  const std::int64_t now = now_ns();
  if (was_busy_) busy_ns_ += now - noted_ns_;
  was_busy_ = renderer_->main_busy();
  noted_ns_ = now;
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
    show_planned();
  }
  return renderer_->load(*volume);
}

Result<void> RenderThread::take_private_views() {
  const PrivateViews* const views = to_.private_views == nullptr ? nullptr : to_.private_views->newest();
  return views == nullptr ? Result<void>{} : renderer_->want(*views);
}

void RenderThread::take_frames() {
  if (to_.feed == nullptr) return;
  // A volume that waits goes first: the frames are those of one after it.
  while (!to_.ring.has_published() && renderer_->wants_frame()) {
    const FedFrame* const frame = to_.feed->front();
    if (frame == nullptr) return;
    renderer_->take_frame(*frame);
    to_.feed->pop();
  }
}

}  // namespace fanlight
