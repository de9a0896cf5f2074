// SPDX-License-Identifier: Apache-2.0
#include "acquisition/replay/replay_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "proto/base/clock.hpp"

namespace fanlight {

namespace {

// A smaller delay is caught up by the next frames; with a larger one the caller is too slow, and all later
// frames are delayed.
constexpr std::int64_t kMostLateNs = 100'000'000;

SourceDescription describe(const Recording& recording) {
  const RecordingSummary& summary = recording.summary();
  SourceDescription source{.name = fmt::format("replay:{}", summary.name),
                           .geometry = summary.geometry,
                           .frames_per_volume = summary.frames_in_longest_sweep,
                           .first_angle_rad = radians(summary.smallest_angle_deg),
                           .last_angle_rad = radians(summary.largest_angle_deg),
                           .notes = summary.notes};
  if (const RecordedStream* const stream = recording.stream()) {
    source.counts_volumes = stream->facts.counts_volumes;
    source.frames_per_volume = std::max(source.frames_per_volume, stream->facts.frames_per_volume);
    source.usual_frames = stream->facts.usual_frames;
    source.first_angle_rad = stream->facts.first_angle_rad;
    source.last_angle_rad = stream->facts.last_angle_rad;
  }
  return source;
}

}  // namespace

Result<std::unique_ptr<ReplaySource>> ReplaySource::create(const Config& config) {
  if (!(config.speed >= 0.01 && config.speed <= 1000)) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("the replay speed is {}, expected 0.01 to 1000", config.speed)};
  }
  Recording::Config reading = config.recording;
  if (config.ending == Ending::kOnce) reading.pixels = Recording::Pixels::kForward;
  auto recording = Recording::open(reading);
  if (!recording) return recording.error();
  return std::unique_ptr<ReplaySource>(new ReplaySource(config, *std::move(recording)));
}

ReplaySource::ReplaySource(const Config& config, Recording recording)
    : recording_(std::move(recording)),
      pace_(config.pace),
      speed_(config.speed),
      ending_(config.ending),
      description_(describe(recording_)) {
  const auto frames = static_cast<std::int64_t>(recording_.frames().size());
  const std::int64_t duration_ns = recording_.frames().back().time_ns;
  pass_ns_ = duration_ns + duration_ns / (frames - 1);
}

Result<std::optional<FrameStamp>> ReplaySource::next_frame(std::stop_token stop) {
  if (failure_) return *failure_;
  const auto frames = static_cast<std::uint32_t>(recording_.frames().size());
  if (position_ == frames) {
    if (ending_ == Ending::kOnce) {
      if (const auto finished = recording_.finish(); !finished) return finished.error();
      return std::optional<FrameStamp>{};
    }
    position_ = 0;
    ++pass_;
    pass_sequence_ = next_sequence_;
    pass_volume_ = next_volume_;
  }
  current_ = backward_pass() ? frames - 1 - position_ : position_;

  if (pace_ == Pace::kRecorded) {
    const std::int64_t now = now_ns();
    if (!started_) start_ns_ = now;
    started_ = true;
    const std::int64_t late_ns = now - capture_time_ns();
    if (late_ns > kMostLateNs) {
      start_ns_ += late_ns;
      ++delays_;
    }
    if (!pacer_.wait_until(capture_time_ns(), stop)) return std::optional<FrameStamp>{};
  }
  if (stop.stop_requested()) return std::optional<FrameStamp>{};

  const FrameStamp stamped = repeats_stamps() ? recorded_stamp() : stamp();
  next_sequence_ = std::max(next_sequence_, stamped.sequence + 1);
  next_volume_ = std::max(next_volume_, stamped.volume_index + 1);
  ++position_;
  return std::optional(stamped);
}

FrameFault ReplaySource::known_fault() const {
  if (repeats_stamps()) return recording_.stream()->frames[current_].fault;
  return recording_.frames()[current_].valid ? FrameFault::kNone : FrameFault::kInvalid;
}

FrameFault ReplaySource::read_pixels(std::span<std::uint8_t> pixels, std::stop_token /*stop*/) {
  const auto read = recording_.read_frame(current_, pixels);
  if (read) return FrameFault::kNone;
  failure_ = read.error();
  return FrameFault::kCut;
}

std::int64_t ReplaySource::capture_time_ns() const {
  const std::int64_t recorded_ns = recording_.frames()[current_].time_ns;
  const std::int64_t in_pass_ns =
      backward_pass() ? recording_.frames().back().time_ns - recorded_ns : recorded_ns;
  const std::int64_t played_ns = static_cast<std::int64_t>(pass_) * pass_ns_ + in_pass_ns;
  if (pace_ == Pace::kAsFastAsTaken) return start_ns_ + played_ns;
  return start_ns_ + std::llround(static_cast<double>(played_ns) / speed_);
}

/// The first pass has the source's own numbers; each further one goes on behind the one before.
FrameStamp ReplaySource::recorded_stamp() const {
  const RecordedStream& stream = *recording_.stream();
  FrameStamp stamp = stream.frames[current_].stamp;
  if (pass_ > 0) {
    stamp.sequence += pass_sequence_ - stream.smallest_sequence;
    stamp.volume_index += pass_volume_ - stream.smallest_volume_index;
  }
  stamp.capture_time_ns = capture_time_ns();
  return stamp;
}

FrameStamp ReplaySource::stamp() const {
  const auto& frames = recording_.frames();
  const auto& sweeps = recording_.sweeps();
  const Recording::Frame& frame = frames[current_];
  const Recording::Sweep& sweep = sweeps[frame.sweep];
  const std::uint64_t first_volume = sweeps.front().volume_index;
  const std::uint64_t last_volume = sweeps.back().volume_index;
  const std::uint64_t volumes_before = pass_ * (last_volume - first_volume + 1);
  const std::uint32_t in_sweep = current_ - sweep.first_frame;

  FrameStamp stamp{.sequence = next_sequence_ + frame.lost_before,
                   .volume_index = volumes_before + sweep.volume_index,
                   .frame_index = in_sweep,
                   .frames_in_sweep = sweep.frames,
                   .direction = sweep.direction,
                   .angle_rad = frame.angle_rad,
                   .capture_time_ns = capture_time_ns()};
  if (backward_pass()) {
    // In a backward pass, the frames lost before a frame are the ones lost after it.
    const bool has_next = in_sweep + 1 < sweep.frames;
    stamp.sequence = next_sequence_ + (has_next ? frames[current_ + 1].lost_before : 0);
    stamp.volume_index = volumes_before + first_volume + (last_volume - sweep.volume_index);
    stamp.frame_index = sweep.frames - 1 - in_sweep;
    stamp.direction =
        sweep.direction == SweepDirection::kForward ? SweepDirection::kBackward : SweepDirection::kForward;
  }
  return stamp;
}

}  // namespace fanlight
