// SPDX-License-Identifier: Apache-2.0
#include "acquisition/assembly/assembler.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "proto/model/fan_geometry.hpp"

namespace fanlight {

namespace {

bool usable(double angle_rad) {
  return std::abs(angle_rad) < kPi / 2;
}  // false for a NaN

std::uint64_t saturating_difference(std::uint64_t number, std::uint64_t amount) {
  return number - std::min(number, amount);
}

}  // namespace

Assembler::Assembler(const Dependencies& dependencies) : Assembler(dependencies, Config{}) {}

Assembler::Assembler(const Dependencies& dependencies, const Config& config)
    : dependencies_(dependencies),
      config_(config),
      reversal_(config.range),
      thumbnails_(dependencies.ring.frame_capacity()),
      check_(dependencies.ring.frame_capacity()),
      volume_(dependencies.ring, dependencies.writer_bell) {
  if (config.correction == MismatchCorrection::kOn) {
    hysteresis_.emplace(dependencies.ring.frame_capacity(), dependencies.counters);
  }
}

Assembler::~Assembler() {
  abandon();
}

std::span<std::uint8_t> Assembler::place(const FrameStamp& frame, const FanGeometry& geometry,
                                         const std::stop_token& stop) {
  thread_owner_.check();
  AcquisitionCounters& counters = dependencies_.counters;
  placed_.reset();
  const Arrival arrival = classify(frame);
  if (arrival == Arrival::kRepeated || arrival == Arrival::kLate) {
    count_unplaced(arrival == Arrival::kRepeated ? counters.frames_repeated : counters.frames_late);
    return {};
  }
  placed_ = frame;
  placed_arrival_ = arrival;
  if (arrival == Arrival::kNewest) follow_geometry(frame);
  if (arrival == Arrival::kNewest && config_.cut == SweepCut::kByIndex) enter_sweep_of(frame);
  if (!usable(frame.angle_rad)) {
    reject(frame, FrameFault::kInvalid);
    return {};
  }
  if (arrival == Arrival::kNewest && config_.cut == SweepCut::kByTurning) follow_angle(frame, stop);
  if (sweep_.finished || (volume_.is_open() && volume_->full())) {
    placed_.reset();
    count_unplaced(counters.frames_over_capacity);
    mark(frame, SequenceWindow::Frame::kUsable);
    leave_sweep_after(frame);
    return {};
  }
  if (!volume_.is_open() && !volume_.open(geometry, stop)) {
    if (!stop.stop_requested()) reject(frame, FrameFault::kMisfit);
    return {};
  }
  return volume_->next_frame_pixels();
}

void Assembler::commit() {
  thread_owner_.check();
  FrameStamp frame = *std::exchange(placed_, std::nullopt);
  frame.commit_number = ++committed_;
  {
    AcquisitionCounters& counters = dependencies_.counters;
    const SeqLock::Entry entry(counters.seq_lock);
    counters.frames_received.add();
    counters.frames_pending.set(++pending_);
    if (placed_arrival_ == Arrival::kReordered) counters.frames_reordered.add();
  }
  const std::uint32_t index = volume_->stamp().frames;
  volume_.add(frame);
  // Before leave_sweep_after(): it may end the sweep and hand the volume to the reader.
  if (dependencies_.frame_queue != nullptr) {
    dependencies_.frame_queue->put(frame, volume_->geometry(), volume_->frame_pixels(index));
  }
  mark(frame, SequenceWindow::Frame::kUsable);
  leave_sweep_after(frame);
}

void Assembler::reject(const FrameStamp& frame, FrameFault fault) {
  thread_owner_.check();
  const bool was_placed = placed_ && placed_->sequence == frame.sequence;
  const Arrival arrival = was_placed ? placed_arrival_ : classify(frame);
  placed_.reset();
  const bool fresh = arrival == Arrival::kNewest || arrival == Arrival::kReordered;
  if (arrival == Arrival::kNewest && !was_placed && config_.cut == SweepCut::kByIndex) enter_sweep_of(frame);
  count_unplaced(faults(fault));
  if (!fresh) return;
  mark(frame, SequenceWindow::Frame::kUseless);
  leave_sweep_after(frame);
}

void Assembler::end_of_source() {
  thread_owner_.check();
  settle_below(window_.next());
  if (sweep_.announced > 0) cut_off_below(sweep_.announced);
  finish_volume();
  sweep_.finished = true;
}

void Assembler::abandon() {
  settle_below(window_.next());
  sweep_.gaps = {};
  if (!volume_.is_open()) return;
  volume_.abandon();
  settle_pending(dependencies_.counters.frames_abandoned, pending_);
}

// ---- the sequence ----

Assembler::Arrival Assembler::classify(const FrameStamp& frame) {
  if (frame.after_interruption) restart_sequence(frame.sequence);
  const Arrival arrival = window_.judge(frame.sequence);
  if (arrival == Arrival::kRestart) {
    dependencies_.counters.sequence_restarts.add();
    restart_sequence(frame.sequence);
    return Arrival::kNewest;
  }
  return arrival == Arrival::kReordered && !accepts(frame) ? Arrival::kLate : arrival;
}

bool Assembler::accepts(const FrameStamp& frame) const {
  if (sweep_.finished || geometry_revision_ != frame.geometry_revision) return false;
  return config_.cut == SweepCut::kByTurning || (sweep_.known && frame.volume_index == sweep_.index);
}

void Assembler::restart_sequence(std::uint64_t sequence) {
  abandon();
  window_.begin_at(sequence);
  sweep_ = {.index = sweep_.index + 1};
  reversal_.reset();
  if (hysteresis_) hysteresis_->forget_volumes();
  check_.forget_volumes();
}

void Assembler::mark(const FrameStamp& frame, SequenceWindow::Frame use) {
  const std::uint64_t before = sweep_.gaps.never_arrived;
  window_.mark(frame.sequence, use, sweep_.gaps);
  dependencies_.counters.frames_missing.add(sweep_.gaps.never_arrived - before);
}

void Assembler::settle_below(std::uint64_t sequence) {
  const std::uint64_t before = sweep_.gaps.never_arrived;
  window_.settle_below(sequence, sweep_.gaps);
  dependencies_.counters.frames_missing.add(sweep_.gaps.never_arrived - before);
}

// ---- sweeps ----

void Assembler::follow_geometry(const FrameStamp& frame) {
  if (geometry_revision_ == frame.geometry_revision) return;
  const bool changed = geometry_revision_.has_value();
  geometry_revision_ = frame.geometry_revision;
  if (!changed) return;
  dependencies_.counters.geometry_changes.add();
  // A changed index ends the sweep in enter_sweep_of().
  if (config_.cut == SweepCut::kByIndex && frame.volume_index != sweep_.index) return;
  settle_below(std::min(frame.sequence, sweep_.end));
  cut_off_below(sweep_.announced > 0 ? sweep_.announced : last_sweep_frames_);
  finish_volume();
  sweep_ = {.index = sweep_.index + 1};
  reversal_.reset();
}

/// Counts the frames that the open sweep lacks of `frames`, because it ends in its middle.
void Assembler::cut_off_below(std::uint64_t frames) {
  if (!volume_.is_open()) return;
  sweep_.cut_off +=
      saturating_difference(frames, volume_.frames() + sweep_.gaps.without_frame + sweep_.cut_off);
}

void Assembler::enter_sweep_of(const FrameStamp& frame) {
  if (sweep_.known && frame.volume_index == sweep_.index) return;
  // Frames lost since the last frame belong to the sweep that ends, unless this frame's index in its own
  // sweep shows that they belong to the new one, or the old sweep had already ended.
  const std::uint64_t first = saturating_difference(frame.sequence, frame.frame_index);
  settle_below(std::min(first, sweep_.end));
  finish_volume();
  settle_below(first);
  sweep_ = {.index = frame.volume_index, .known = true};
  sweep_.cut_off =
      saturating_difference(frame.frame_index, saturating_difference(frame.sequence, window_.settled()));
}

void Assembler::leave_sweep_after(const FrameStamp& frame) {
  if (config_.cut == SweepCut::kByTurning || frame.frames_in_sweep == 0) return;
  sweep_.announced = frame.frames_in_sweep;
  if (frame.sequence >= frame.frame_index) {
    sweep_.end = frame.sequence - frame.frame_index + frame.frames_in_sweep;
  }
  // Decided by the frame's index and not by a count of frames: a sweep also ends where frames were lost.
  if (frame.frame_index < frame.frames_in_sweep - 1) return;
  settle_below(frame.sequence + 1);
  finish_volume();
  sweep_.finished = true;
}

void Assembler::follow_angle(const FrameStamp& frame, const std::stop_token& stop) {
  if (reversal_.reversed(frame.sequence, frame.angle_rad)) end_sweep_at_reversal(stop);
  sweep_.direction = reversal_.direction();
}

void Assembler::end_sweep_at_reversal(const std::stop_token& stop) {
  // A reversal is detected some frames after the extreme. These frames belong to the sweep that begins.
  const std::uint64_t extreme = reversal_.extreme_sequence();
  const auto stamps = volume_.is_open() ? volume_.stamps() : std::span<const FrameStamp>();
  const auto after =
      std::ranges::find_if(stamps, [extreme](const FrameStamp& stamp) { return stamp.sequence > extreme; });
  const auto kept = static_cast<std::uint32_t>(after - stamps.begin());
  settle_below(extreme + 1);
  // A frame from before the extreme that arrived after it stays with the frames it arrived with.
  sweep_.gaps.without_frame += static_cast<std::uint64_t>(std::count_if(
      after, stamps.end(), [extreme](const FrameStamp& stamp) { return stamp.sequence < extreme; }));
  if (kept > 0) {
    const OpenVolume::Rest rest = volume_.cut(kept);
    finish_volume();
    if (rest.frames > 0 && !volume_.carry_over(rest, stop))
      settle_pending(dependencies_.counters.frames_abandoned, rest.frames);
  }
  sweep_ = {.index = sweep_.index + 1};
}

// ---- the end of a volume ----

/// The places of removed frames in the sequence become gaps.
AngleCheck::Findings Assembler::remove_outliers() {
  const OpenVolume::Angles angles = volume_.remove_outliers();
  sweep_.gaps.longest = std::max(sweep_.gaps.longest, angles.longest_run);
  sweep_.gaps.without_frame += angles.removed;
  if (angles.removed > 0) settle_pending(dependencies_.counters.frames_invalid, angles.removed);
  return angles.findings;
}

std::optional<DroppedSweep::Reason> Assembler::reason_to_drop(double gap_rad) const {
  using Reason = DroppedSweep::Reason;
  const std::uint32_t frames = volume_.frames();
  const SequenceGaps& gaps = sweep_.gaps;
  const auto all = static_cast<double>(frames + gaps.without_frame + sweep_.cut_off);
  const auto too_many = [&](std::uint64_t missing) {
    return missing > 1 && static_cast<double>(missing) > config_.most_missing_share * all;
  };
  if (too_many(gaps.without_frame)) return Reason::kMissing;
  if (gaps.longest > config_.longest_gap_frames) return Reason::kRun;
  if (gap_rad > 0) return Reason::kGap;
  if (too_many(gaps.without_frame + sweep_.cut_off)) return Reason::kCutOff;
  if (frames < 2 || !volume_.has_moved()) return Reason::kStill;
  return std::nullopt;
}

void Assembler::finish_volume() {
  if (!volume_.is_open()) return;
  if (volume_.frames() == 0) return volume_.abandon();
  const AngleCheck::Findings angles = remove_outliers();
  if (const auto reason = reason_to_drop(angles.gap_rad)) {
    drop(*reason, angles);
  } else {
    publish();
  }
}

void Assembler::drop(DroppedSweep::Reason reason, const AngleCheck::Findings& angles) {
  using Reason = DroppedSweep::Reason;
  AcquisitionCounters& counters = dependencies_.counters;
  const std::uint32_t frames = volume_.frames();
  if (dependencies_.dropped != nullptr) {
    dependencies_.dropped->put({.volume_index = config_.cut == SweepCut::kByTurning
                                                    ? sweep_.index
                                                    : volume_->stamp().source_volume_index,
                                .reason = reason,
                                .frames = frames,
                                .missing = sweep_.gaps.without_frame,
                                .longest_run = sweep_.gaps.longest,
                                .gap_deg = degrees(angles.gap_rad),
                                .usual_step_deg = degrees(angles.usual_step_rad)});
  }
  volume_.abandon();
  if (reason == Reason::kCutOff) {
    settle_pending(counters.frames_abandoned, frames);
  } else if (reason == Reason::kStill) {
    counters.volumes_short.add();
    settle_pending(counters.frames_in_short_volumes, frames);
  } else {
    counters.volumes_incomplete.add();
    settle_pending(counters.frames_in_incomplete_volumes, frames);
  }
}

void Assembler::correct_as_recorded() {
  const std::uint64_t first = volume_->stamp().first_frame_sequence;
  const auto found =
      std::ranges::lower_bound(config_.recorded, first, {}, &RecordedCorrection::first_frame_sequence);
  if (found != config_.recorded.end() && found->first_frame_sequence == first)
    volume_->turn_by(found->correction_rad);
}

void Assembler::check_sweep() {
  const SweepWarnings warnings = check_.check(*volume_, thumbnails_);
  volume_->stamp().warnings = warnings;
  for (std::size_t i = 0; i < kSweepWarnings; ++i)
    if (warnings.has(static_cast<SweepWarning>(i))) (dependencies_.counters.*kWarnedVolumes[i]).add();
}

void Assembler::publish() {
  VolumeStamp& stamp = volume_->stamp();
  AcquisitionCounters& counters = dependencies_.counters;
  if (config_.cut == SweepCut::kByTurning) {
    stamp.source_volume_index = sweep_.index;
    stamp.direction = sweep_.direction;
  }
  stamp.frames_missing = static_cast<std::uint32_t>(sweep_.gaps.without_frame);
  if (stamp.frames_missing > 0) counters.volumes_interpolated.add();
  last_sweep_frames_ = stamp.frames + stamp.frames_missing;
  volume_->sort_by_angle();
  thumbnails_.take(*volume_, volume_.stamps());
  if (config_.checks_sweeps) check_sweep();
  if (hysteresis_) hysteresis_->correct(*volume_, thumbnails_);
  if (!hysteresis_) correct_as_recorded();
  settle_pending(counters.frames_assembled, stamp.frames);
  volume_.publish();
}

// ---- counting ----

void Assembler::count_unplaced(Counter& reason) {
  const SeqLock::Entry entry(dependencies_.counters.seq_lock);
  dependencies_.counters.frames_received.add();
  reason.add();
}

void Assembler::settle_pending(Counter& fate, std::uint32_t frames) {
  const SeqLock::Entry entry(dependencies_.counters.seq_lock);
  pending_ -= frames;
  dependencies_.counters.frames_pending.set(pending_);
  fate.add(frames);
}

Counter& Assembler::faults(FrameFault fault) {
  AcquisitionCounters& counters = dependencies_.counters;
  switch (fault) {
    case FrameFault::kDamaged:
      return counters.frames_damaged;
    case FrameFault::kCut:
      return counters.frames_cut;
    case FrameFault::kMisfit:
      return counters.frames_misfit;
    default:
      return counters.frames_invalid;
  }
}

}  // namespace fanlight
