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
// The state is reported at each sweep, and this often within a long one.
constexpr std::int64_t kTellNs = 200'000'000;
// After a jump, frames of a recording that came out of order still have numbers above those of the last pass.
constexpr std::uint64_t kReordered = 64;
constexpr double kLongestBeginS = 1e6;

SourceDescription describe(const Recording& recording, ReplaySource::Ending ending) {
  const RecordingSummary& summary = recording.summary();
  SourceDescription source{.name = fmt::format("replay:{}", summary.name),
                           .geometry = summary.geometry,
                           .is_grid = recording.is_grid(),
                           .frames_per_volume = summary.frames_in_longest_sweep,
                           .volumes = ending == ReplaySource::Ending::kOnce ? summary.sweeps : 0,
                           .first_angle_rad = radians(summary.smallest_angle_deg),
                           .last_angle_rad = radians(summary.largest_angle_deg),
                           .origin = FrameOrigin::kRecording,
                           .notes = summary.notes};
  if (const RecordedStream* const stream = recording.stream()) {
    source.counts_volumes = stream->facts.counts_volumes;
    source.frames_per_volume = std::max(source.frames_per_volume, stream->facts.frames_per_volume);
    source.usual_frames = stream->facts.usual_frames;
    source.begun_utc_s = stream->facts.begun_utc_s;
    source.simulated = stream->facts.simulated;
    source.first_angle_rad = stream->facts.first_angle_rad;
    source.last_angle_rad = stream->facts.last_angle_rad;
  }
  return source;
}

ReplayStatus::File file_state(FileChange change) {
  if (change == FileChange::kNone) return ReplayStatus::File::kSame;
  return change == FileChange::kChanged ? ReplayStatus::File::kChanged : ReplayStatus::File::kRemoved;
}

}  // namespace

Result<std::unique_ptr<ReplaySource>> ReplaySource::create(const Config& config) {
  if (!(config.speed >= kLeastReplaySpeed && config.speed <= kMostReplaySpeed)) {
    return Error{ErrorCode::kInvalidArgument, fmt::format("the replay speed is {}, expected {} to {}",
                                                          config.speed, kLeastReplaySpeed, kMostReplaySpeed)};
  }
  if (!(config.from_s >= 0 && config.from_s <= kLongestBeginS)) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("the replay begins at {} s, expected 0 or more", config.from_s)};
  }
  Recording::Config reading = config.recording;
  if (config.ending == Ending::kOnce) reading.pixels = Recording::Pixels::kFromFile;
  auto recording = Recording::open(reading);
  if (!recording) return recording.error();
  // One volume of a damaged file would be rendered without an error. A player reports it at the end.
  if (config.link == nullptr)
    if (auto whole = recording->check_pixels(); !whole) return whole.error();
  return std::unique_ptr<ReplaySource>(new ReplaySource(config, *std::move(recording)));
}

ReplaySource::ReplaySource(const Config& config, Recording recording)
    : recording_(std::move(recording)),
      pace_(config.pace),
      link_(config.link),
      description_(describe(recording_, config.ending)),
      bell_(link_ != nullptr ? link_->player_bell : own_bell_),
      speed_(config.speed),
      ending_(config.ending) {
  const std::int64_t duration_ns = recording_.frames().back().time_ns;
  pass_ns_ = duration_ns + duration_ns / (frames() - 1);
  position_ = recording_.sweeps()[sweep_at(config.from_s)].first_frame;
  jumped_ = position_ > 0;  // the frames before are not lost
  if (config.paused && link_ != nullptr) rest_after_sweep(recording_.frames()[position_].sweep);
  status_.sweeps = static_cast<std::uint32_t>(recording_.sweeps().size());
  status_.duration_s = static_cast<double>(duration_ns) / 1e9;
  status_.can_play_backward = recording_.has_quick_access();
  tell();
}

Result<std::optional<FrameStamp>> ReplaySource::next_frame(std::stop_token stop) {
  rests_ = false;
  while (!stop.stop_requested()) {
    take_orders();
    if (failure_ && link_ == nullptr) return *failure_;
    if (failure_) {
      status_.trouble = std::exchange(failure_, std::nullopt)->message;
      state_ = State::kFailed;
      tell();
    }
    if (state_ != State::kPlaying) {
      wait_for_order(stop);
      continue;
    }
    if (rest_after_ && position_ > *rest_after_) {
      rest(State::kPaused);
      break;
    }
    if (position_ == frames()) {
      const auto goes_on = turn_round();
      if (!goes_on) return goes_on.error();
      if (!*goes_on) break;
    }
    current_ = turned(position_);
    if (wait_for_current(stop)) return std::optional(next_stamp());
  }
  return std::optional<FrameStamp>{};
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

// ---- orders ----

void ReplaySource::take_orders() {
  if (link_ == nullptr) return;
  bool any = false;
  while (const auto order = link_->orders.take()) {
    take(*order);
    any = true;
  }
  if (any) tell();
}

void ReplaySource::take(const ReplayOrder& order) {
  using Wish = ReplayOrder::Wish;
  switch (order.wish) {
    case Wish::kPlay:
      return play();
    case Wish::kPause:
      rest_after_.reset();
      if (state_ == State::kPlaying) state_ = State::kPaused;
      return;
    case Wish::kStep:
      return step(order.sweeps);
    case Wish::kSeek:
      return seek(order.time_s);
    case Wish::kFrame:
      return show_frame(order.number);
    case Wish::kSpeed:
      anchored_ = false;
      speed_ = order.speed;
      return;
    case Wish::kEnding:
      ending_ = order.ending;
      return;
  }
}

void ReplaySource::play() {
  rest_after_.reset();
  const bool over = state_ == State::kEnded || state_ == State::kFailed ||
                    (position_ == frames() && ending_ == Ending::kOnce);
  if (over) {
    backward_ = false;
    jump_to_sweep(0);
  }
  if (state_ != State::kPlaying) anchored_ = false;
  state_ = State::kPlaying;
}

/// Counts sweeps in the order in which this pass plays them.
void ReplaySource::step(std::int32_t sweeps) {
  const auto count = static_cast<std::int64_t>(recording_.sweeps().size());
  const auto in_order = [&](std::uint32_t position) {
    const std::int64_t sweep = recording_.frames()[turned(position)].sweep;
    return backward_ ? count - 1 - sweep : sweep;
  };
  if (sweeps > 0) {
    if (position_ == frames()) {
      if (ending_ == Ending::kOnce) return;
      begin_pass(ending_ == Ending::kToAndFro && !backward_);
    }
    // A step that is under way is not shown yet: the next one counts from its end.
    const std::int64_t before = rest_after_ ? in_order(*rest_after_) : in_order(position_) - 1;
    const std::int64_t last = std::min(before + sweeps, count - 1);
    rest_after_sweep(static_cast<std::uint32_t>(backward_ ? count - 1 - last : last));
  } else if (sweeps < 0) {
    // The picture shows the last whole sweep: the one before the next frame's.
    const std::int64_t next = position_ == frames() ? count : in_order(position_);
    const std::int64_t shown = rest_after_ ? in_order(*rest_after_) : next - 1;
    const std::int64_t target = std::max<std::int64_t>(0, shown + sweeps);
    const auto sweep = static_cast<std::uint32_t>(backward_ ? count - 1 - target : target);
    jump_to_sweep(sweep);
    rest_after_sweep(sweep);
  }
  state_ = State::kPlaying;
}

void ReplaySource::seek(double time_s) {
  const std::uint32_t sweep = sweep_at(time_s);
  const bool shows_one = state_ != State::kPlaying || rest_after_;
  jump_to_sweep(sweep);
  if (shows_one) rest_after_sweep(sweep);
  state_ = State::kPlaying;
}

void ReplaySource::show_frame(std::uint64_t number) {
  std::uint64_t index = number;
  if (const RecordedStream* const stream = recording_.stream()) {
    const auto found = std::ranges::find_if(
        stream->frames, [number](const RecordedFrame& frame) { return frame.stamp.sequence >= number; });
    index = static_cast<std::uint64_t>(found - stream->frames.begin());
  }
  const std::uint32_t sweep = recording_.frames()[std::min<std::uint64_t>(index, frames() - 1)].sweep;
  jump_to_sweep(sweep);
  rest_after_sweep(sweep);
  state_ = State::kPlaying;
}

std::uint32_t ReplaySource::sweep_at(double time_s) const {
  const auto& all = recording_.frames();
  const auto time_ns =
      static_cast<std::int64_t>(std::clamp(time_s * 1e9, 0.0, static_cast<double>(all.back().time_ns)));
  const auto after = std::ranges::upper_bound(all, time_ns, {}, &Recording::Frame::time_ns);
  return after == all.begin() ? 0 : std::prev(after)->sweep;
}

/// Index in the pass of the sweep's first frame to play.
void ReplaySource::jump_to_sweep(std::uint32_t sweep) {
  const Recording::Sweep& to = recording_.sweeps()[sweep];
  position_ = turned(backward_ ? to.first_frame + to.frames - 1 : to.first_frame);
  jumped_ = true;
  anchored_ = false;
}

void ReplaySource::rest_after_sweep(std::uint32_t sweep) {
  const Recording::Sweep& last = recording_.sweeps()[sweep];
  rest_after_ = turned(backward_ ? last.first_frame : last.first_frame + last.frames - 1);
}

// ---- passes ----

Result<bool> ReplaySource::turn_round() {
  if (ending_ != Ending::kOnce) {
    begin_pass(ending_ == Ending::kToAndFro && !backward_);
    return true;
  }
  const auto finished = recording_.finish();
  if (link_ == nullptr) return finished ? Result<bool>(false) : Result<bool>(finished.error());
  if (!finished) status_.trouble = finished.error().message;
  rest(finished ? State::kEnded : State::kFailed);
  return false;
}

void ReplaySource::begin_pass(bool backward) {
  // The gap between two passes is one mean frame period, at any speed.
  if (anchored_) anchor(capture_time_ns() + played_ns(pass_ns_ - recording_.frames().back().time_ns), 0);
  backward_ = backward;
  position_ = 0;
  if (recording_.stream() != nullptr) {
    sequence_shift_ = next_sequence_ - recording_.stream()->smallest_sequence;
    volume_shift_ = next_volume_ - recording_.stream()->smallest_volume_index;
  }
  if (!repeats_stamps()) volume_shift_ = next_volume_ - recording_.sweeps().front().volume_index;
}

void ReplaySource::rest(State state) {
  state_ = state;
  rests_ = true;
  rest_after_.reset();
  anchored_ = false;
  // The assembler has closed the sweep; where sweeps have no numbers, only an interruption opens the next.
  if (!description_.counts_volumes) jumped_ = true;
  tell();
}

// ---- time ----

std::int64_t ReplaySource::in_pass_ns(std::uint32_t frame) const {
  const std::int64_t recorded_ns = recording_.frames()[frame].time_ns;
  return backward_ ? recording_.frames().back().time_ns - recorded_ns : recorded_ns;
}

std::int64_t ReplaySource::capture_time_ns() const {
  return anchor_ns_ + played_ns(in_pass_ns(current_) - anchor_pass_ns_);
}

std::int64_t ReplaySource::played_ns(std::int64_t recorded_ns) const {
  if (pace_ == Pace::kAsFastAsTaken) return recorded_ns;
  return std::llround(static_cast<double>(recorded_ns) / speed_);
}

void ReplaySource::anchor(std::int64_t now_ns, std::int64_t pass_ns) {
  anchor_ns_ = now_ns;
  anchor_pass_ns_ = pass_ns;
  anchored_ = true;
}

bool ReplaySource::wait_for_current(const std::stop_token& stop) {
  if (pace_ == Pace::kAsFastAsTaken) {
    if (!anchored_) anchor(next_free_ns_, in_pass_ns(current_));
    return true;
  }
  const std::stop_callback wake(stop, [this] { bell_.ring(); });
  std::int64_t now = now_ns();
  // The frames of a step are due at once: a display waits for its picture.
  if (!anchored_ || rest_after_) anchor(now, in_pass_ns(current_));
  const std::int64_t late_ns = now - capture_time_ns();
  if (late_ns > kMostLateNs) {
    anchor_ns_ += late_ns;
    ++delays_;
  }
  while (capture_time_ns() > now) {
    if (bell_.wait(capture_time_ns() - now)) return false;
    now = now_ns();
  }
  return !stop.stop_requested();
}

void ReplaySource::wait_for_order(const std::stop_token& stop) {
  const std::stop_callback wake(stop, [this] { bell_.ring(); });
  if (!stop.stop_requested()) bell_.wait(-1);
}

// ---- stamps ----

FrameStamp ReplaySource::next_stamp() {
  if (jumped_) renumber();
  FrameStamp stamped = repeats_stamps() ? recorded_stamp() : stamp();
  stamped.recorded_number =
      recording_.stream() != nullptr ? recording_.stream()->frames[current_].stamp.sequence : current_;
  stamped.after_interruption |= std::exchange(jumped_, false);
  next_sequence_ = std::max(next_sequence_, stamped.sequence + 1);
  next_volume_ = std::max(next_volume_, stamped.volume_index + 1);
  next_free_ns_ = stamped.capture_time_ns + pass_ns_ - recording_.frames().back().time_ns;
  ++position_;
  const bool other_sweep = recording_.frames()[current_].sweep != status_.sweep;
  if (link_ != nullptr && (other_sweep || now_ns() - told_ns_ > kTellNs)) {
    status_.file = file_state(recording_.file_change());
    tell();
  }
  return stamped;
}

/// The frame current_ gets the next free numbers.
void ReplaySource::renumber() {
  if (repeats_stamps()) {
    const FrameStamp& recorded = recording_.stream()->frames[current_].stamp;
    sequence_shift_ = next_sequence_ + kReordered - recorded.sequence;
    volume_shift_ = next_volume_ - recorded.volume_index;
  } else {
    volume_shift_ += next_volume_ - stamp().volume_index;
  }
}

/// The first pass has the source's own numbers; each further one continues after the one before.
FrameStamp ReplaySource::recorded_stamp() const {
  FrameStamp stamp = recording_.stream()->frames[current_].stamp;
  stamp.sequence += sequence_shift_;
  stamp.volume_index += volume_shift_;
  stamp.capture_time_ns = capture_time_ns();
  return stamp;
}

FrameStamp ReplaySource::stamp() const {
  const auto& frames = recording_.frames();
  const auto& sweeps = recording_.sweeps();
  const Recording::Frame& frame = frames[current_];
  const Recording::Sweep& sweep = sweeps[frame.sweep];
  const std::uint32_t in_sweep = current_ - sweep.first_frame;

  FrameStamp stamp{.sequence = next_sequence_ + frame.lost_before,
                   .volume_index = volume_shift_ + sweep.volume_index,
                   .frame_index = in_sweep,
                   .frames_in_sweep = sweep.frames,
                   .direction = sweep.direction,
                   .angle_rad = frame.angle_rad,
                   .capture_time_ns = capture_time_ns()};
  if (backward_) {
    // In a backward pass, the frames lost before a frame are the ones lost after it.
    const bool has_next = in_sweep + 1 < sweep.frames;
    stamp.sequence = next_sequence_ + (has_next ? frames[current_ + 1].lost_before : 0);
    stamp.volume_index =
        volume_shift_ + sweeps.front().volume_index + (sweeps.back().volume_index - sweep.volume_index);
    stamp.frame_index = sweep.frames - 1 - in_sweep;
    stamp.direction =
        sweep.direction == SweepDirection::kForward ? SweepDirection::kBackward : SweepDirection::kForward;
  }
  return stamp;
}

// ---- status ----

void ReplaySource::tell() {
  if (link_ == nullptr) return;
  if (state_ == State::kPlaying) status_.trouble.clear();
  status_.state = state_;
  status_.backward = backward_;
  status_.ending = ending_;
  status_.speed = speed_;
  status_.sweep = recording_.frames()[current_].sweep;
  status_.time_s = static_cast<double>(recording_.frames()[current_].time_ns) / 1e9;
  told_ns_ = now_ns();
  link_->status.draft() = status_;
  link_->status.publish();
}

}  // namespace fanlight
