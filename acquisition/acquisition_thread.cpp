// SPDX-License-Identifier: Apache-2.0
#include "acquisition/acquisition_thread.hpp"

#include <pthread.h>

#include <new>
#include <optional>
#include <utility>

#include "proto/base/clock.hpp"

namespace fanlight {

namespace {

Assembler::Config sweeps_of(const SourceDescription& source, MismatchCorrection correction,
                            std::span<const RecordedCorrection> recorded) {
  return {.cut = source.counts_volumes ? SweepCut::kByIndex : SweepCut::kByTurning,
          .range = {source.first_angle_rad, source.last_angle_rad},
          .correction = correction,
          .recorded = recorded,
          .checks_sweeps = !source.is_grid};
}

}  // namespace

AcquisitionThread::AcquisitionThread(const Dependencies& dependencies, MismatchCorrection correction) noexcept
    : dependencies_(dependencies),
      assembler_({.ring = dependencies.ring,
                  .writer_bell = dependencies.writer_bell,
                  .counters = dependencies.counters,
                  .frame_queue = dependencies.frame_queue,
                  .dropped = dependencies.dropped},
                 sweeps_of(dependencies.source.description(), correction, dependencies.recorded)),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

void AcquisitionThread::run(const std::stop_token& stop) {
  pthread_setname_np(pthread_self(), "acquisition");
  std::optional<Pulse::OfThisThread> pulse;
  if (dependencies_.pulse != nullptr) pulse.emplace(*dependencies_.pulse);
  State state = State::kFailed;
  try {
    state = pull_frames(stop);
  } catch (const std::bad_alloc&) {
    error_ = {ErrorCode::kUnavailable, "the process has no memory left for the source's frames"};
  }
  // The sweep that a source fails in is not whole.
  if (state == State::kStopped || state == State::kFailed) {
    assembler_.abandon();
  } else {
    assembler_.end_of_source();
  }
  state_.store(state, std::memory_order_release);
  dependencies_.ended_bell.ring();
}

AcquisitionThread::State AcquisitionThread::pull_frames(const std::stop_token& stop) {
  FrameSource& source = dependencies_.source;
  std::uint64_t delays = 0;
  while (!stop.stop_requested()) {
    Pulse::beat();
    Result<std::optional<FrameStamp>> next = source.next_frame(stop);
    dependencies_.counters.source_delays.add(source.delays() - std::exchange(delays, source.delays()));
    if (!next) {
      error_ = next.error();
      return State::kFailed;
    }
    const std::optional<FrameStamp>& frame = *next;
    if (frame) {
      dependencies_.counters.frame_age_s.set(static_cast<double>(now_ns() - frame->capture_time_ns) / 1e9);
      take_frame(*frame, stop);
    } else if (source.rests() && !stop.stop_requested()) {
      assembler_.end_of_source();
    } else {
      break;
    }
  }
  return stop.stop_requested() ? State::kStopped : State::kEnded;
}

void AcquisitionThread::take_frame(const FrameStamp& frame, const std::stop_token& stop) {
  FrameSource& source = dependencies_.source;
  const FanGeometry& geometry = source.description().geometry;
  FrameFault fault = source.known_fault();
  if (fault == FrameFault::kNone) {
    const std::span<std::uint8_t> pixels = assembler_.place(frame, geometry, stop);
    if (pixels.empty()) return pass_on_unplaced(frame, stop);
    fault = source.read_pixels(pixels, stop);
    if (fault == FrameFault::kNone) {
      // Before commit(), which may hand the volume to its reader.
      for_each_open_tap([&](FrameQueue& queue) { queue.put(frame, geometry, pixels); });
      return assembler_.commit();
    }
  }
  if (!stop.stop_requested())
    for_each_open_tap([&](FrameQueue& queue) { queue.put_fault(frame, geometry, fault); });
  assembler_.reject(frame, fault);
}

/// A replay of the recording gives the frame to an assembler again, which does not use it either.
void AcquisitionThread::pass_on_unplaced(const FrameStamp& frame, const std::stop_token& stop) {
  if (stop.stop_requested()) return;
  const FanGeometry& geometry = dependencies_.source.description().geometry;
  // Its pixels are read into the first queue that has room, and copied from there before its reader sees
  // them.
  FrameTap* const first = dependencies_.taps[0];
  FrameTap* const second = dependencies_.taps[1];
  for (FrameTap* const tap : {first, second}) {
    if (tap == nullptr || !tap->is_open()) continue;
    const std::span<std::uint8_t> pixels = tap->queue().reserve(geometry.frame_bytes());
    if (pixels.empty()) continue;  // and counted there
    // The first one has refused where this is the second.
    FrameTap* const other = tap == first && second != nullptr && second->is_open() ? second : nullptr;
    const FrameFault fault = dependencies_.source.read_pixels(pixels, stop);
    if (fault != FrameFault::kNone) {
      tap->queue().put_fault(frame, geometry, fault);
      if (other != nullptr) other->queue().put_fault(frame, geometry, fault);
      return;
    }
    if (other != nullptr) other->queue().put(frame, geometry, pixels);
    return tap->queue().commit(frame, geometry);
  }
}

}  // namespace fanlight
