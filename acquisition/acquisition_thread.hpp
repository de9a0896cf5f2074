// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <thread>

#include "acquisition/assembly/assembler.hpp"
#include "acquisition/source/frame_source.hpp"
#include "proto/exchange/frame_tap.hpp"
#include "proto/exchange/pulse.hpp"

namespace fanlight {

/// Thread that reads frames from a source and publishes volumes in the ring. It runs from construction until
/// the source ends or fails, or a stop is requested. Its loop does not allocate, lock or log.
class AcquisitionThread {
 public:
  enum class State : std::uint8_t {
    kRunning,
    kEnded,    ///< the source has no more frames; its last sweep is published
    kFailed,   ///< the source cannot continue: see error()
    kStopped,  ///< as requested; the open sweep was abandoned
  };

  /// All must outlive the thread. Nothing else may use the source or write to the ring while the thread runs.
  struct Dependencies {
    FrameSource& source;
    VolumeRing& ring;
    Doorbell& writer_bell;  ///< the ring's
    AcquisitionCounters& counters;
    Doorbell& ended_bell;               ///< rung once, when the state is no longer kRunning
    FrameQueue* frame_queue = nullptr;  ///< receives each frame ahead of its volume; nullptr: no queue
    DroppedSweeps* dropped = nullptr;   ///< receives the sweeps that give no volume; nullptr: none
    std::span<const RecordedCorrection> recorded{};  ///< see Assembler::Config
    /// Receive every frame as the source gives it: the recorder's, and the server's; nullptr: none.
    std::array<FrameTap*, 2> taps{};
    Pulse* pulse = nullptr;  ///< beats while the thread's loop runs; nullptr: none
  };

  /// Starts the thread. Ends the process where the system cannot create a thread.
  explicit AcquisitionThread(const Dependencies& dependencies,
                             MismatchCorrection correction = MismatchCorrection::kOn) noexcept;
  /// Requests a stop and joins the thread.
  ~AcquisitionThread() = default;
  AcquisitionThread(const AcquisitionThread&) = delete;
  AcquisitionThread& operator=(const AcquisitionThread&) = delete;

  /// Any thread. Wakes the source, or the wait for a free slot of the ring; does not wait for the thread's
  /// end.
  void request_stop() { thread_.request_stop(); }

  /// Any thread.
  State state() const { return state_.load(std::memory_order_acquire); }

  /// Why the source failed. Any thread; only after state() was kFailed.
  const Error& error() const { return error_; }

 private:
  void run(const std::stop_token& stop);
  State pull_frames(const std::stop_token& stop);
  void take_frame(const FrameStamp& frame, const std::stop_token& stop);
  void pass_on_unplaced(const FrameStamp& frame, const std::stop_token& stop);
  /// Calls pass(queue) for each tap that is open.
  template <typename Pass>
  void for_each_open_tap(const Pass& pass) const {
    for (FrameTap* const tap : dependencies_.taps)
      if (tap != nullptr && tap->is_open()) pass(tap->queue());
  }

  Dependencies dependencies_;
  Assembler assembler_;
  Error error_;  // written by the thread until state_ leaves kRunning; constant afterwards
  std::atomic<State> state_{State::kRunning};
  std::jthread thread_;  // last member: it uses all of the above until it is joined
};

}  // namespace fanlight
