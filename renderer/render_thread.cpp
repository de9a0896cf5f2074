#include "renderer/render_thread.hpp"

#include <pthread.h>

namespace fanlight {

namespace {

// While the GPU works the thread waits for it, and looks this often whether a scene or a volume has come.
constexpr std::int64_t kLookNs = 2'000'000;

}  // namespace

RenderThread::RenderThread(std::unique_ptr<Renderer> renderer, const Dependencies& dependencies)
    : renderer_(std::move(renderer)),
      to_(dependencies),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

RenderThread::~RenderThread() {
  thread_.request_stop();
  to_.bell.ring();
}

void RenderThread::run(const std::stop_token& stop) {
  pthread_setname_np(pthread_self(), "render");
  while (!stop.stop_requested()) {
    if (const auto done = step(); !done) {
      to_.failures.draft() = done.error();
      to_.failures.publish();
      return;
    }
  }
}

Result<void> RenderThread::step() {
  if (const NumberedScene* newest = to_.scenes.newest()) renderer_->show(*newest);
  if (auto taken = take_volume(); !taken) return taken;
  take_frames();
  if (auto advanced = renderer_->advance(); !advanced) return advanced;
  if (renderer_->collect(to_.pictures.draft())) {
    if (to_.pictures.publish()) to_.counters.pictures_replaced.add();
    return {};  // its slot is free now: look for work before sleeping
  }
  if (renderer_->busy()) return renderer_->wait(kLookNs);
  to_.bell.wait(-1);
  return {};
}

Result<void> RenderThread::take_volume() {
  if (!renderer_->wants_volume()) return {};
  const auto volume = to_.ring.take();
  return volume ? renderer_->load(*volume) : Result<void>();
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
