#pragma once

#include <cstdint>
#include <span>
#include <stop_token>

#include "proto/counter.hpp"
#include "proto/doorbell.hpp"
#include "proto/frame.hpp"
#include "proto/volume_ring.hpp"

namespace fanlight {

/// Turns the frames of a sweep into a volume of the ring, in whichever direction the motor went.
///
/// Life of a frame: place() -> its pixels written to the memory named -> commit(); or reject(). A frame that
/// is placed and never committed was never received: the gap in the sequence counts it as missing.
/// Life of a sweep: first frame -> ... -> published, or dropped as too short, when its last announced frame
/// or the first of another sweep arrives, or the source ends.
///
/// One thread, the acquisition thread. Allocates nothing.
class Assembler {
 public:
  /// All must outlive the assembler. `writer_bell` is the one that the ring rings when a slot comes free.
  struct Dependencies {
    VolumeRing& ring;
    Doorbell& writer_bell;
    AcquisitionCounters& counters;
  };

  explicit Assembler(const Dependencies& dependencies);
  /// Abandons the sweep under way.
  ~Assembler();
  Assembler(const Assembler&) = delete;
  Assembler& operator=(const Assembler&) = delete;

  /// The ring's memory for this frame (rows x columns bytes, row major), to be filled before commit() and
  /// not touched after it. Empty where the frame has no place (an unusable angle, a volume that is full):
  /// it is counted, go on with the next. Waits only where the ring processes all volumes and has no room;
  /// empty as well, and nothing counted, when `stop` ends that wait.
  std::span<std::uint8_t> place(const FrameStamp& frame, const std::stop_token& stop);

  /// Counts the frame just placed as part of its volume.
  void commit();

  /// Counts a frame that is of no use, placed before or not; it can still be the last of its sweep.
  /// Precondition: `fault` is one.
  void reject(const FrameStamp& frame, FrameFault fault);

  /// Publishes the sweep under way as far as it came: no other frame will follow.
  void end_of_source();

  /// Gives the sweep under way up; its frames count as abandoned.
  void abandon();

  /// Frames committed to the sweep under way.
  std::uint32_t frames_pending() const { return volume_ == nullptr ? 0 : volume_->stamp().frames; }

 private:
  Counter& faults(FrameFault fault);
  void enter_sweep_of(const FrameStamp& frame);
  void count(const FrameStamp& frame);
  void leave_sweep_after(const FrameStamp& frame);
  void finish_volume();
  Volume* wait_for_volume(const std::stop_token& stop);

  Dependencies dependencies_;
  Volume* volume_ = nullptr;  // of the sweep under way, from its first usable frame on
  FrameStamp placed_;
  std::uint64_t next_sequence_ = 0;
  std::uint64_t sweep_index_ = 0;
  bool sweep_known_ = false;     // sweep_index_ means something
  bool sweep_finished_ = false;  // its last announced frame has come
};

}  // namespace fanlight
