#include "acquisition/assembler.hpp"

#include <algorithm>
#include <cmath>

#include "proto/fan_geometry.hpp"

namespace fanlight {

namespace {

// A motor that stands still would give a volume without thickness, and the look-up table a division by zero.
constexpr double kLeastSpreadRad = radians(0.01);

bool usable(double angle_rad) {
  return std::abs(angle_rad) < kPi / 2;
}  // false for a NaN

bool moved(const Volume& volume) {
  const auto [smallest, largest] = std::ranges::minmax(volume.angles_rad());
  return largest - smallest >= kLeastSpreadRad;
}

}  // namespace

Assembler::Assembler(const Dependencies& dependencies) : dependencies_(dependencies) {}

Assembler::~Assembler() {
  abandon();
}

std::span<std::uint8_t> Assembler::place(const FrameStamp& frame, const std::stop_token& stop) {
  enter_sweep_of(frame);
  AcquisitionCounters& counters = dependencies_.counters;
  if (!usable(frame.angle_rad)) {
    reject(frame, FrameFault::kInvalid);
    return {};
  }
  if (sweep_finished_ || (volume_ != nullptr && volume_->full())) {
    count(frame);
    counters.frames_over_capacity.add();
    leave_sweep_after(frame);
    return {};
  }
  if (volume_ == nullptr) volume_ = wait_for_volume(stop);
  if (volume_ == nullptr) return {};
  placed_ = frame;
  return volume_->next_frame_pixels();
}

void Assembler::commit() {
  count(placed_);
  volume_->add_frame(placed_);
  leave_sweep_after(placed_);
}

void Assembler::reject(const FrameStamp& frame, FrameFault fault) {
  enter_sweep_of(frame);
  count(frame);
  faults(fault).add();
  leave_sweep_after(frame);
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

void Assembler::end_of_source() {
  finish_volume();
  sweep_finished_ = true;
}

void Assembler::abandon() {
  if (volume_ == nullptr) return;
  dependencies_.counters.frames_abandoned.add(volume_->stamp().frames);
  dependencies_.ring.abandon();
  volume_ = nullptr;
}

void Assembler::enter_sweep_of(const FrameStamp& frame) {
  if (sweep_known_ && frame.volume_index == sweep_index_) return;
  finish_volume();
  sweep_index_ = frame.volume_index;
  sweep_known_ = true;
  sweep_finished_ = false;
}

void Assembler::count(const FrameStamp& frame) {
  dependencies_.counters.frames_received.add();
  if (frame.sequence > next_sequence_) {
    dependencies_.counters.frames_missing.add(frame.sequence - next_sequence_);
  }
  next_sequence_ = frame.sequence + 1;
}

void Assembler::leave_sweep_after(const FrameStamp& frame) {
  // By the frame's place, not by a count of frames: the sweep also ends where some of it were lost.
  if (frame.frames_in_sweep == 0 || frame.frame_index < frame.frames_in_sweep - 1) return;
  finish_volume();
  sweep_finished_ = true;
}

void Assembler::finish_volume() {
  if (volume_ == nullptr) return;
  AcquisitionCounters& counters = dependencies_.counters;
  const std::uint32_t frames = volume_->stamp().frames;
  if (frames >= 2 && moved(*volume_)) {
    volume_->sort_by_angle();
    dependencies_.ring.publish();
    counters.frames_assembled.add(frames);
  } else {
    dependencies_.ring.abandon();
    counters.frames_in_short_volumes.add(frames);
    if (frames > 0) counters.volumes_short.add();
  }
  volume_ = nullptr;
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

}  // namespace fanlight
