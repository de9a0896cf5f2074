// SPDX-License-Identifier: Apache-2.0
// Assembler: the volume that is open, from its first frame to the ring, or to the record of dropped sweeps.
#include <algorithm>
#include <numeric>
#include <utility>

#include "acquisition/assembly/assembler.hpp"
#include "proto/model/fan_geometry.hpp"

namespace fanlight {

namespace {

// A motor that stands still gives a volume without thickness, and a division by zero in the angle look-up
// table.
constexpr double kLeastSpreadRad = radians(0.01);

// Marks an index of a frame. A volume has fewer frames.
constexpr std::uint32_t kOutlier = 1U << 31;

bool moved(const Volume& volume) {
  const auto [smallest, largest] = std::ranges::minmax(volume.angles_rad());
  return largest - smallest >= kLeastSpreadRad;
}

}  // namespace

bool Assembler::open_volume(const FanGeometry& geometry, const std::stop_token& stop) {
  Volume* const volume = wait_for_volume(stop);
  if (volume == nullptr) return false;
  if (!volume->holds(geometry)) {
    dependencies_.ring.abandon();
    return false;
  }
  volume->set_geometry(geometry);
  volume_ = volume;
  return true;
}

Volume* Assembler::wait_for_volume(const std::stop_token& stop) {
  Volume* volume = dependencies_.ring.begin();
  if (volume != nullptr) return volume;
  const std::stop_callback wake(stop, [this] { dependencies_.writer_bell.ring(); });
  while (!stop.stop_requested()) {
    volume = dependencies_.ring.begin();
    if (volume != nullptr) return volume;
    dependencies_.writer_bell.wait(-1);
  }
  return nullptr;
}

/// Checks the angles of the volume's frames in order of capture; the result names indices of by_sequence_.
AngleCheck::Findings Assembler::check_angles() {
  by_sequence_.resize(volume_->stamp().frames);
  std::iota(by_sequence_.begin(), by_sequence_.end(), 0U);
  std::ranges::sort(by_sequence_, {}, [this](std::uint32_t index) { return stamps_[index].sequence; });
  frames_to_check_.clear();
  for (const std::uint32_t index : by_sequence_)
    frames_to_check_.push_back({.sequence = stamps_[index].sequence, .angle_rad = stamps_[index].angle_rad});
  return angle_check_.check(frames_to_check_);
}

/// Their places in the sequence become gaps.
void Assembler::remove_outliers(std::span<const std::size_t> outliers) {
  if (outliers.empty()) return;
  std::uint64_t run = 0;
  for (std::size_t i = 0; i < outliers.size(); ++i) {
    run = i > 0 && outliers[i] == outliers[i - 1] + 1 ? run + 1 : 1;
    sweep_.gaps.longest = std::max<std::uint64_t>(sweep_.gaps.longest, run);
  }
  sweep_.gaps.without_frame += outliers.size();
  // From the highest index down: remove_frame() moves the last frame, which is none of them then.
  for (const std::size_t outlier : outliers) by_sequence_[outlier] |= kOutlier;
  for (std::uint32_t index = volume_->stamp().frames; index-- > 0;) {
    if (std::ranges::find(by_sequence_, index | kOutlier) == by_sequence_.end()) continue;
    volume_->remove_frame(index);
    stamps_[index] = stamps_[volume_->stamp().frames];
  }
  const auto kept = std::span(stamps_).first(volume_->stamp().frames);
  const auto [first, last] = std::ranges::minmax_element(kept, {}, &FrameStamp::sequence);
  volume_->set_span(*first, *last);
  settle_pending(dependencies_.counters.frames_invalid, static_cast<std::uint32_t>(outliers.size()));
}

std::optional<DroppedSweep::Reason> Assembler::reason_to_drop(double gap_rad) const {
  using Reason = DroppedSweep::Reason;
  const std::uint32_t frames = volume_->stamp().frames;
  const SequenceGaps& gaps = sweep_.gaps;
  const auto all = static_cast<double>(frames + gaps.without_frame + sweep_.cut_off);
  const auto too_many = [&](std::uint64_t missing) {
    return missing > 1 && static_cast<double>(missing) > config_.most_missing_share * all;
  };
  if (too_many(gaps.without_frame)) return Reason::kMissing;
  if (gaps.longest > config_.longest_gap_frames) return Reason::kRun;
  if (gap_rad > 0) return Reason::kGap;
  if (too_many(gaps.without_frame + sweep_.cut_off)) return Reason::kCutOff;
  if (frames < 2 || !moved(*volume_)) return Reason::kStill;
  return std::nullopt;
}

void Assembler::finish_volume() {
  if (volume_ == nullptr) return;
  if (volume_->stamp().frames == 0) {
    dependencies_.ring.abandon();
    volume_ = nullptr;
    return;
  }
  const AngleCheck::Findings angles = check_angles();
  remove_outliers(angles.outliers);
  if (const auto reason = reason_to_drop(angles.gap_rad)) {
    drop(*reason, angles);
  } else {
    publish();
  }
}

void Assembler::drop(DroppedSweep::Reason reason, const AngleCheck::Findings& angles) {
  using Reason = DroppedSweep::Reason;
  AcquisitionCounters& counters = dependencies_.counters;
  const std::uint32_t frames = volume_->stamp().frames;
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
  dependencies_.ring.abandon();
  volume_ = nullptr;
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
  if (hysteresis_) hysteresis_->correct(*volume_, std::span(stamps_).first(stamp.frames));
  if (!hysteresis_) correct_as_recorded();
  settle_pending(counters.frames_assembled, stamp.frames);
  volume_ = nullptr;
  dependencies_.ring.publish();
}

}  // namespace fanlight
