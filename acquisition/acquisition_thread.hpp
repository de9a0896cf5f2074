#pragma once

#include <atomic>
#include <cstdint>
#include <thread>

#include "acquisition/assembler.hpp"
#include "acquisition/frame_source.hpp"

namespace fanlight {

/// The thread that pulls frames out of a source and puts volumes into the ring, from construction until the
/// source ends or fails, or a stop is requested. Its loop neither allocates nor locks nor logs.
class AcquisitionThread {
 public:
  enum class State : std::uint8_t {
    kRunning,
    kEnded,    ///< the source has no more frames; its last sweep is published
    kFailed,   ///< the source cannot go on: see error()
    kStopped,  ///< as requested; the sweep under way was abandoned
  };

  /// All must outlive the thread; nobody else touches the source, or writes to the ring, while it runs.
  struct Dependencies {
    FrameSource& source;
    VolumeRing& ring;
    Doorbell& writer_bell;  ///< the ring's
    AcquisitionCounters& counters;
    Doorbell& ended_bell;       ///< rung once, when the state is no longer kRunning
    FrameFeed* feed = nullptr;  ///< gets each frame ahead of its volume; null where nobody wants that
  };

  /// Starts at once. Ends the process where the system has no thread to give.
  explicit AcquisitionThread(const Dependencies& dependencies,
                             MismatchCorrection correction = MismatchCorrection::kOn) noexcept;
  /// Requests a stop and waits for the thread's end.
  ~AcquisitionThread() = default;
  AcquisitionThread(const AcquisitionThread&) = delete;
  AcquisitionThread& operator=(const AcquisitionThread&) = delete;

  /// Any thread. Wakes the source, or the wait for room in the ring; does not wait for the end.
  void request_stop() { thread_.request_stop(); }

  /// Any thread.
  State state() const { return state_.load(std::memory_order_acquire); }

  /// Why the source failed. Any thread; only after state() was kFailed.
  const Error& error() const { return error_; }

 private:
  void run(const std::stop_token& stop);
  State pull_frames(const std::stop_token& stop);

  Dependencies dependencies_;
  Assembler assembler_;
  Error error_;  // the thread's until state_ leaves kRunning, nobody's to write afterwards
  std::atomic<State> state_{State::kRunning};
  std::jthread thread_;  // last: it uses all of the above from the moment it exists until it is joined
};

}  // namespace fanlight
