#include "renderer/render_thread.hpp"

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
  if (renderer_->wants_volume()) {
    if (const auto volume = to_.ring.take()) {
      if (auto loaded = renderer_->load(*volume); !loaded) return loaded;
    }
  }
  if (auto advanced = renderer_->advance(); !advanced) return advanced;
  if (renderer_->collect(to_.pictures.draft())) {
    if (to_.pictures.publish()) to_.counters.pictures_replaced.add();
    return {};  // its slot is free now: look for work before sleeping
  }
  if (renderer_->busy()) return renderer_->wait(kLookNs);
  to_.bell.wait(-1);
  return {};
}

}  // namespace fanlight
