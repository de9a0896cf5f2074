// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "proto/exchange/doorbell.hpp"
#include "proto/model/fan_geometry.hpp"
#include "proto/model/frame.hpp"
#include "proto/model/pipeline_counters.hpp"

namespace fanlight {

/// A frame in the queue.
struct QueuedFrame {
  /// With its commit number. The angle is the measured one: the volume may later add a correction to it.
  /// Where the source does not count volumes, volume index, frame index and direction are not valid.
  FrameStamp stamp;
  FanGeometry geometry;
  std::span<const std::uint8_t> pixels;  ///< rows x columns bytes, row major, row 0 nearest the probe
  FrameFault fault = FrameFault::kNone;  ///< else `pixels` is empty
};

/// Bounded queue of frame copies from the acquisition thread (the only writer) to the render thread (the only
/// reader), ahead of the volume of these frames. The volume may still be dropped. If the queue
/// is full, the frame is counted and not queued: the volume contains it in any case.
///
/// The constructor reserves address space for all slots; afterwards no call locks, allocates or blocks. A
/// slot's pages are used from its first frame on. A queue that runs empty begins again with the first slot,
/// so that a reader which keeps up costs the pages of a few frames, whatever the capacity is.
class FrameQueue {
 public:
  struct Config {
    std::uint64_t largest_frame_bytes = 0;  ///< larger frames are not queued
    std::uint32_t slots = 8;                ///< capacity, including the frame that the reader is reading
  };
  /// Must outlive the queue. Each queued frame rings it.
  struct Dependencies {
    Doorbell& reader_bell;
  };

  FrameQueue(const Config& config, const Dependencies& dependencies);

  /// Writer: copies a frame to the end of the queue. False, and counted, where the queue is full or the frame
  /// too large. `pixels`: rows x columns bytes of `geometry`, row major.
  bool put(const FrameStamp& stamp, const FanGeometry& geometry, std::span<const std::uint8_t> pixels);

  /// Writer: memory for the pixels of the next frame, `bytes` long, the same until commit(). Empty, and
  /// counted, where the queue is full or the frame too large.
  std::span<std::uint8_t> reserve(std::uint64_t bytes);
  /// Writer: puts the frame whose pixels were written to reserve(). Precondition: reserve() gave memory.
  void commit(const FrameStamp& stamp, const FanGeometry& geometry);

  /// Writer: puts a frame that is unusable. As put(), without pixels.
  bool put_fault(const FrameStamp& stamp, const FanGeometry& geometry, FrameFault fault);

  /// Writer: whether the next frame would find no room. Counts nothing.
  bool is_full() const;

  /// Reader: the oldest queued frame; nullptr: none. The same one, and valid, until pop().
  const QueuedFrame* front() const;

  /// Reader: removes front(). Precondition: front() was not nullptr.
  void pop();

  const QueueCounters& counters() const { return counters_; }

 private:
  bool has_room();  // counts where not
  void publish(const QueuedFrame& frame);

  std::uint64_t largest_frame_bytes_;
  Dependencies dependencies_;
  std::unique_ptr<std::uint8_t[]> pixels_;  // of all slots, largest_frame_bytes_ each
  std::vector<QueuedFrame> slots_;
  // Writer only.
  std::span<std::uint8_t> reserved_;
  std::uint64_t first_slot_number_ = 0;  // of the frame that found the queue empty last
  // Numbers of frames put and popped so far. A slot belongs to the writer until put_ has passed it, and to
  // the reader until popped_ has.
  std::atomic<std::uint64_t> put_{0};
  std::atomic<std::uint64_t> popped_{0};
  QueueCounters counters_;
};

}  // namespace fanlight
