#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "proto/counter.hpp"
#include "proto/doorbell.hpp"
#include "proto/fan_geometry.hpp"
#include "proto/frame.hpp"

namespace fanlight {

/// A frame as the feed hands it on.
struct FedFrame {
  /// With its number of arrival. The angle is as measured: a volume may add a correction to it later. Of a
  /// source that does not count volumes, the volume, the place in the sweep and the direction say nothing.
  FrameStamp stamp;
  FanGeometry geometry;
  std::span<const std::uint8_t> pixels;  ///< rows x columns bytes, row major, row 0 nearest the probe
};

/// Copies of frames on their way from the acquisition thread (the one writer) to the render thread (the one
/// reader), ahead of the volume that they will be part of; should their sweep be dropped, there is none. A
/// frame that finds no room is not fed, and counted: the ring of volumes has it all the same.
///
/// All memory is allocated by the constructor; afterwards no call locks, allocates or waits.
class FrameFeed {
 public:
  struct Config {
    std::uint64_t largest_frame_bytes = 0;  ///< larger frames are not fed
    std::uint32_t slots = 8;  ///< frames that can wait for the reader, the one it looks at included
  };
  /// Must outlive the feed; each frame that is fed rings it.
  struct Dependencies {
    Doorbell& reader_bell;
  };

  FrameFeed(const Config& config, const Dependencies& dependencies);

  /// Writer: copies the frame behind those that wait. False, and counted, where the feed is full or the frame
  /// too large. `pixels` are rows x columns bytes of `geometry`, row major.
  bool put(const FrameStamp& stamp, const FanGeometry& geometry, std::span<const std::uint8_t> pixels);

  /// Reader: the oldest frame that waits, the same one until pop(); nullptr where none does. Valid until
  /// pop().
  const FedFrame* front() const;

  /// Reader: gives the frame of front() up. Precondition: front() gave one.
  void pop();

  const FeedCounters& counters() const { return counters_; }

 private:
  std::uint64_t largest_frame_bytes_;
  Dependencies dependencies_;
  std::unique_ptr<std::uint8_t[]> pixels_;  // of all slots, largest_frame_bytes_ each
  std::vector<FedFrame> slots_;
  // Frames ever put and ever popped: a slot is the writer's until the first has passed it, then the reader's
  // until the second has.
  std::atomic<std::uint64_t> put_{0};
  std::atomic<std::uint64_t> popped_{0};
  FeedCounters counters_;
};

}  // namespace fanlight
