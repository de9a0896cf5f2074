// SPDX-License-Identifier: Apache-2.0
#include "renderer/render_thread.hpp"

#include <fmt/format.h>
#include <pthread.h>

#include <algorithm>
#include <exception>
#include <new>
#include <utility>

#include "proto/base/clock.hpp"

namespace fanlight {

namespace {

// While the GPU works, the thread waits for it, and looks for a new scene or volume at this interval.
constexpr std::int64_t kPollNs = 2'000'000;
// Window over which the main view's busy share is measured.
constexpr std::int64_t kWindowNs = 1'000'000'000;
// While the server has no room for an answer, it is tried again at this interval.
constexpr std::int64_t kAnswerPollNs = 10'000'000;
// At an end without hurry the GPU may finish its work: longer than any watchdog.
constexpr std::int64_t kMostSettleNs = 600'000'000'000;
// So many volumes without memory in a row are more than a short lack of it.
constexpr std::size_t kVolumesWithoutMemory = 3;
// So that a moved light, and the next band of a cast, do not wait for the copies of a whole sweep.
constexpr std::size_t kMostFramesInTurn = 8;

}  // namespace

RenderThread::RenderThread(DeviceRenderer renderer, const Dependencies& dependencies)
    : to_(dependencies),
      health_(dependencies.link),
      renderer_(std::move(renderer), {.link = dependencies.link,
                                      .counters = dependencies.counters,
                                      .health = health_,
                                      .remake = dependencies.remake}),
      sizes_(renderer_->config().size, renderer_->config().largest()),
      requested_(renderer_->scenes().wanted()),
      finest_mm_(renderer_->config().geometry.finest_mm()),
      cine_(dependencies.ring),
      settle_ns_(kMostSettleNs),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

void RenderThread::run(const std::stop_token& stop) {
  pthread_setname_np(pthread_self(), "render");
  const Pulse::OfThisThread pulse(to_.link.pulse);
  governor_.scene_came(requested_.scene, now_ns());
  sizes_.scene_came(requested_, now_ns());
  while (!stop.stop_requested()) {
    Pulse::beat();
    to_.counters.turn_began_ns.set(now_ns());
    if (const auto done = step_within_memory(); !done && !recover_within_memory(done.error(), stop)) break;
  }
  to_.counters.turn_began_ns.set(0);
  volume_ = {};
  cine_.end();
  renderer_.end(settle_ns_);
  ended_.ring();
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
  return renderer_.is_gone();
}

RenderThread::~RenderThread() {
  thread_.request_stop();
  to_.link.to_renderer.ring();
}

void RenderThread::take_scene() {
  if (const NumberedScene* newest = to_.link.scenes.newest()) {
    const Scene::Near& near = newest->scene.near;
    const Scene::Near& before = requested_.scene.near;
    // Where it ends was not looked for in the volume that is loaded.
    if (near.is_removed() && (near.tissue != before.tissue || near.before_bone != before.before_bone))
      load_again();
    requested_ = *newest;
    governor_.scene_came(requested_.scene, now_ns());
    sizes_.scene_came(requested_, now_ns());
    renderer_->show(requested_);
  }
  if (const WantedSizes* const wanted = to_.link.wanted_sizes.newest()) sizes_.want(*wanted);
  if (quality_changed(now_ns())) show_degraded();
}

/// Whether pictures that are begun now have another quality than those before.
bool RenderThread::quality_changed(std::int64_t now_ns) const {
  const NumberedScene& shown = renderer_->scenes().wanted();
  return governor_.in_force(now_ns) != shown.deadline || size_in_force(now_ns) != shown.scene.size;
}

/// What is too much for the usual size is too much for a finer one.
std::optional<PictureSize> RenderThread::size_in_force(std::int64_t now_ns) const {
  if (governor_.in_force(now_ns).measures != DeadlineMeasures{}) return std::nullopt;
  return sizes_.in_force(now_ns);
}

void RenderThread::show_degraded() {
  const std::int64_t now = now_ns();
  const DeadlineState state = governor_.in_force(now);
  NumberedScene shown{.revision = requested_.revision,
                      .scene = degraded(requested_.scene, state.measures, finest_mm_),
                      .deadline = state};
  shown.scene.size = size_in_force(now);
  renderer_->show(shown);
}

void RenderThread::rest() {
  const std::int64_t now = now_ns();
  if (quality_changed(now)) return;  // just now
  // Orders behind one that was answered in this turn: their ring is used up.
  if (!volume_order_ && !to_.link.orders.empty()) return;
  auto change_ns = governor_.next_change_ns(now);
  if (const auto size_ns = sizes_.next_change_ns(now))
    change_ns = std::min(change_ns.value_or(*size_ns), *size_ns);
  if (const auto try_ns = renderer_->scenes().next_try_ns())
    change_ns = std::min(change_ns.value_or(*try_ns), *try_ns);
  if (const auto cine_ns = cine_.next_change_ns())
    change_ns = std::min(change_ns.value_or(*cine_ns), *cine_ns);
  // The server does not ring when it has made room.
  if (has_unsent()) change_ns = std::min(change_ns.value_or(INT64_MAX), now + kAnswerPollNs);
  to_.counters.turn_began_ns.set(0);
  to_.link.to_renderer.wait(change_ns ? std::max<std::int64_t>(*change_ns - now, 0) : -1);
}

Result<void> RenderThread::step_within_memory() {
  try {
    return step();
  } catch (const std::bad_alloc&) {
    // Not a loss: the GPU still works on what was submitted, and its memory must stay until that is done.
    return Error{ErrorCode::kBroken, "the process has no memory left for the renderer"};
  }
}

bool RenderThread::recover_within_memory(const Error& cause, const std::stop_token& stop) {
  try {
    if (!renderer_.replace(cause, stop)) return false;
  } catch (const std::exception& error) {  // no memory, or no thread
    renderer_.fail({ErrorCode::kLost,
                    fmt::format("the process has no memory left for a new renderer ({})", error.what())});
    return false;
  }
  sizes_.set_largest(renderer_->config().largest());
  show_degraded();
  volume_due_ = views_due_ = true;
  was_busy_ = false;
  return true;
}

Result<void> RenderThread::step() {
  take_scene();
  look_for_audience();
  take_orders();
  if (auto taken = take_private_views(); !taken) return taken;
  const bool private_turn = private_share_.is_turn(renderer_->private_due() && !renderer_->refines(),
                                                   renderer_->main_busy(), now_ns());
  if (!private_turn) {
    if (auto taken = take_volume(); !taken) return taken;
    take_frames();
  }
  report();
  const auto new_work = private_turn ? Renderer::NewWork::kWaits : Renderer::NewWork::kBegins;
  const auto next = volume_waits() ? Renderer::NextVolume::kWaits : Renderer::NextVolume::kUnknown;
  if (auto advanced = renderer_->advance(new_work, next); !advanced) return advanced;
  answer_volume_order();  // the GPU has its work meanwhile
  if (Mailbox<Picture>& pictures = to_.link.pictures; renderer_->collect(pictures.draft())) {
    renderer_.note_picture();
    governor_.picture_finished(pictures.draft().stamp);
    sizes_.picture_finished(pictures.draft());
    if (pictures.publish()) to_.counters.pictures_replaced.add();
    return {};  // its slot is free now: look for work before waiting
  }
  if (renderer_->collect_private()) {
    private_share_.picture_finished(now_ns());
    return {};
  }
  measure_busy();
  // One observation decides between waiting for the GPU, more private work, and rest: work that ends between
  // two observations would stay uncollected until the next ring of the bell.
  if (renderer_->busy()) {
    // advance() may have made room for the next volume, whose pass 1 runs at the same time as what it
    // submitted.
    const bool more = !private_turn && volume_waits() && renderer_->wants_volume();
    return more ? Result<void>{} : renderer_->wait(kPollNs);
  }
  if (private_turn || !volume_waits()) {
    const auto advanced = renderer_->advance_private();
    if (!advanced) return advanced.error();
    if (*advanced) return {};
  }
  // The GPU has finished what was slow: that is reported before the thread rests.
  if (renderer_->pace() != Watchdog::Pace::kUsual) return renderer_->wait(0);
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

/// The volume on show.
void RenderThread::load_again() {
  if (cine_.is_frozen()) {
    cine_.forget_loaded();
  } else {
    volume_due_ = static_cast<bool>(volume_);
  }
}

/// A client that comes after a rest has no picture yet, whether or not a newer volume has come meanwhile.
void RenderThread::look_for_audience() {
  const std::uint64_t arrivals = to_.link.audience.arrivals();
  if (std::exchange(arrivals_seen_, arrivals) != arrivals) load_again();
}

/// Answers may take several turns: further orders wait for them.
void RenderThread::take_orders() {
  cine_.advance(volume_ ? &*volume_ : nullptr, now_ns());
  while (!volume_order_) {
    auto order = to_.link.orders.take();
    if (!order) break;
    std::visit([this](auto& each) { obey(each); }, *order);
  }
  report_cine();
  sizes_.set_frozen(cine_.status().state == CineStatus::State::kFrozen);
  // The newest volume was to be loaded again: as a kept one now.
  if (cine_.is_frozen() && std::exchange(volume_due_, false)) cine_.forget_loaded();
}

void RenderThread::obey(const CineOrder& order) {
  if (cine_.obey(order, volume_ ? &*volume_ : nullptr, now_ns())) volume_due_ = true;
}

void RenderThread::obey(VolumeOrder& order) {
  volume_order_ = std::move(order);
}

void RenderThread::report_cine() {
  const CineStatus status = cine_.status();
  if (status != reported_cine_ && to_.link.answer(status)) reported_cine_ = status;
}

/// Whether take_volume() has one to load as soon as the renderer wants one.
bool RenderThread::volume_waits() const {
  return cine_.is_frozen() ? cine_.due() != nullptr && is_watched() : to_.ring.has_published();
}

Result<void> RenderThread::take_volume() {
  if (!renderer_->wants_volume()) return {};
  if (cine_.is_frozen()) {
    // New volumes wait in the ring, where they are replaced by newer ones.
    const Volume* const due = cine_.due();
    return due != nullptr && is_watched() ? load_kept(*due) : Result<void>{};
  }
  if (to_.ring.has_published()) {
    volume_ = {};  // a reader holds one at a time
    volume_ = to_.ring.take();
    if (volume_ && is_watched()) return load(Renderer::Loading::kNew);
    if (!volume_) return {};
    to_.counters.volumes_unwatched.add();
  } else if (volume_due_ && volume_ && is_watched()) {
    return load(Renderer::Loading::kAgain);
  }
  return {};
}

void RenderThread::follow_geometry(const Volume& volume) {
  if (finest_mm_ == volume.geometry().finest_mm()) return;
  finest_mm_ = volume.geometry().finest_mm();
  show_degraded();
}

/// Before it is loaded, which begins its cast.
void RenderThread::note_volume() {
  sizes_.volume_came(now_ns());
  if (quality_changed(now_ns())) show_degraded();
}

Result<void> RenderThread::load_kept(const Volume& volume) {
  follow_geometry(volume);
  note_volume();
  const auto loaded = renderer_->load(volume, Renderer::Loading::kKept);
  cine_.note_loaded();
  if (loaded) {
    health_.set_volume_refusal("");
    return {};
  }
  const Error& error = loaded.error();
  if (error.code != ErrorCode::kUnavailable && error.code != ErrorCode::kUnsupported) return error;
  health_.set_volume_refusal(error.message);  // the picture before it stays
  return {};
}

Result<void> RenderThread::load(Renderer::Loading loading) {
  volume_due_ = false;
  follow_geometry(*volume_);
  note_volume();
  const auto loaded = renderer_->load(*volume_, loading);
  if (loaded) {
    health_.set_volume_refusal("");
    short_in_a_row_ = 0;
    remade_for_memory_ = false;
    return {};
  }
  const Error& error = loaded.error();
  if (error.code != ErrorCode::kUnavailable && error.code != ErrorCode::kUnsupported) return error;
  health_.set_volume_refusal(error.message);
  // A volume that had room before has none now, again and again: a new device is tried once. For a volume
  // that is too large it would be of no use.
  const std::uint64_t bytes = volume_->geometry().frame_bytes() * volume_->stamp().frames;
  const bool had_room = bytes <= renderer_->largest_volume_bytes();
  volume_ = {};
  if (error.code == ErrorCode::kUnsupported || !had_room) return {};
  if (++short_in_a_row_ < kVolumesWithoutMemory || remade_for_memory_ || !renderer_.can_be_replaced())
    return {};
  short_in_a_row_ = 0;
  remade_for_memory_ = true;
  return error;
}

Result<void> RenderThread::take_private_views() {
  if (const PrivateViews* const views = to_.link.private_views.newest()) {
    views_ = *views;
    views_due_ = true;
  }
  if (!std::exchange(views_due_, false)) return {};
  return renderer_->want(views_);
}

const Volume* RenderThread::volume_on_show() const {
  if (cine_.is_frozen()) return cine_.on_show();
  return volume_ ? &*volume_ : nullptr;
}

bool RenderThread::has_unsent() const {
  return volume_order_ || ends_due_ || health_.is_due() || cine_.status() != reported_cine_;
}

void RenderThread::answer_volume_order() {
  if (!volume_order_ || !to_.link.has_room_for_answer()) return;
  to_.link.answer(answer_to(*std::exchange(volume_order_, std::nullopt), volume_on_show()));
  to_.counters.turn_began_ns.set(now_ns());  // the driver had no part in this
}

void RenderThread::report() {
  const bool slow = renderer_->pace() != Watchdog::Pace::kUsual;
  health_.set_state(slow ? RenderHealth::State::kSlow : RenderHealth::State::kRunning,
                    slow ? "the GPU works on one submission for longer than usual" : "", now_ns());
  health_.set_scene_refusal(renderer_->scenes().refused_revision(), renderer_->scenes().refusal());
  health_.set_filter_left_out(renderer_->filter_left_out());
  health_.flush();
  if (const PrivateViewEnds* const ends = renderer_->ended_views()) ends_due_ = *ends;
  if (ends_due_ && to_.link.answer(*ends_due_)) ends_due_.reset();
}

void RenderThread::take_frames() {
  if (to_.feed == nullptr) return;
  if (cine_.is_frozen() || !is_watched()) {  // nothing of a volume to come is prepared
    while (to_.feed->front() != nullptr) to_.feed->pop();
    return;
  }
  // Frames of the volume that waits in the ring are staged while it waits.
  const auto waiting = to_.ring.waiting_commit_number();
  for (std::size_t taken = 0; renderer_->wants_frame(); ++taken) {
    const QueuedFrame* const frame = to_.feed->front();
    if (frame == nullptr) return;
    if (stays_queued(frame->stamp.commit_number, waiting, renderer_->replaces_frames())) return;
    if (taken == kMostFramesInTurn && renderer_->main_busy()) return;
    renderer_->take_frame(*frame);
    to_.feed->pop();
  }
}

}  // namespace fanlight
