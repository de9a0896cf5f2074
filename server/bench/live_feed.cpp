// SPDX-License-Identifier: Apache-2.0
#include "server/bench/live_feed.hpp"

#include "proto/base/clock.hpp"

namespace fanlight {

namespace {

constexpr std::uint32_t kFeedSlots = 64;  // what `fanlight serve` has for frames of up to 250 kB

}  // namespace

LiveFeed::LiveFeed(BenchVolumes& volumes, std::int64_t sweep_ns, Arrival arrival)
    : volumes_(volumes),
      sweep_ns_(sweep_ns),
      arrival_(arrival),
      sweep_began_ns_(now_ns()),
      queue_({.largest_frame_bytes = volumes.description().geometry.frame_bytes(), .slots = kFeedSlots},
             {.reader_bell = bell_}) {
  start_sweep();
}

void LiveFeed::start_sweep() {
  arriving_ = &volumes_.next();
  arrived_ = 0;
}

void LiveFeed::advance() {
  for (;;) {
    const std::uint32_t frames = arriving_->stamp().frames;
    const std::uint32_t due_frames = arrival_ == Arrival::kAtOnce ? frames : arrived_ + 1;
    const std::int64_t due_ns = sweep_began_ns_ + sweep_ns_ * due_frames / frames;
    if (now_ns() < due_ns) return;
    const QueuedFrame frame = volumes_.frame(arrived_);
    if (arrival_ == Arrival::kFrameByFrame) queue_.put(frame.stamp, frame.geometry, frame.pixels);
    if (++arrived_ < frames) continue;
    complete_ = arriving_;
    completed_commit_number_ = frame.stamp.commit_number;
    completed_ns_ = due_ns;
    sweep_began_ns_ += sweep_ns_;
    start_sweep();
  }
}

}  // namespace fanlight
