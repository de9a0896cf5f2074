// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/frame_pump.hpp"

#include <algorithm>
#include <chrono>
#include <optional>
#include <span>
#include <thread>

namespace fanlight {

namespace {

/// Counts the numbers that do not come. Frames may come out of order: a number is lost only where its run
/// ends without it.
class SequenceRuns {
 public:
  /// `longest_loss`: as of FrameSource.
  explicit SequenceRuns(std::uint64_t longest_loss) : longest_loss_(longest_loss) {}

  void add(std::uint64_t sequence, bool after_interruption) {
    const bool jumped = frames_ > 0 && sequence > last_ && sequence - last_ - 1 > longest_loss_;
    if (jumped || (after_interruption && frames_ > 0)) {
      lost_before_ += lost_in_run();
      ++interruptions_;
      frames_ = 0;
    }
    first_ = frames_ == 0 ? sequence : std::min(first_, sequence);
    last_ = frames_ == 0 ? sequence : std::max(last_, sequence);
    ++frames_;
    ++all_frames_;
  }
  PumpedFrames counts() const {
    if (longest_loss_ == 0) return {.frames = all_frames_};
    return {.frames = all_frames_, .lost = lost_before_ + lost_in_run(), .interruptions = interruptions_};
  }

 private:
  std::uint64_t lost_in_run() const {
    const std::uint64_t numbers = frames_ == 0 ? 0 : last_ - first_ + 1;
    return numbers > frames_ ? numbers - frames_ : 0;
  }

  std::uint64_t longest_loss_;
  std::uint64_t first_ = 0;  // of the present run
  std::uint64_t last_ = 0;
  std::uint64_t frames_ = 0;
  std::uint64_t all_frames_ = 0;
  std::uint64_t lost_before_ = 0;
  std::uint64_t interruptions_ = 0;
};

}  // namespace

Result<void> pump_frames(FrameSource& source, FrameTap& tap, FullQueue full, const std::stop_token& stop,
                         PumpedFrames& pumped) {
  FrameQueue& queue = tap.queue();
  SequenceRuns runs(source.longest_loss());
  while (!stop.stop_requested()) {
    const auto next = source.next_frame(stop);
    if (!next) return next.error();
    const std::optional<FrameStamp>& frame = *next;
    if (!frame) return {};
    runs.add(frame->sequence, frame->after_interruption);
    pumped = runs.counts();
    while (full == FullQueue::kWait && queue.is_full() && !stop.stop_requested())
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    const FanGeometry& geometry = source.description().geometry;
    FrameFault fault = source.known_fault();
    if (fault == FrameFault::kNone) {
      const std::span<std::uint8_t> pixels = queue.reserve(geometry.frame_bytes());
      if (pixels.empty()) continue;
      fault = source.read_pixels(pixels, stop);
    }
    if (fault == FrameFault::kNone) {
      queue.commit(*frame, geometry);
    } else if (!stop.stop_requested()) {
      queue.put_fault(*frame, geometry, fault);
    }
  }
  return {};
}

}  // namespace fanlight
