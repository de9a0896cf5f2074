#include "renderer/render_thread.hpp"

#include <pthread.h>

#include <algorithm>

#include "proto/clock.hpp"

namespace fanlight {

namespace {

// While the GPU works the thread waits for it, and looks this often whether a scene or a volume has come.
constexpr std::int64_t kLookNs = 2'000'000;

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
  if (auto advanced = renderer_->advance(); !advanced) return advanced;
  if (renderer_->collect(to_.pictures.draft())) {
    deadline_.picture_finished(to_.pictures.draft().stamp);
    if (to_.pictures.publish()) to_.counters.pictures_replaced.add();
    return {};  // its slot is free now: look for work before sleeping
  }
  if (renderer_->busy()) return renderer_->wait(kLookNs);
  rest();
  return {};
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
