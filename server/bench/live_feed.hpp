// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "proto/base/result.hpp"
#include "proto/exchange/frame_queue.hpp"
#include "proto/model/volume.hpp"
#include "server/bench/volumes.hpp"

namespace fanlight {

/// Volumes as from a live probe: the frames of a sweep come one after the other, at equal intervals, and the
/// volume is complete with the last one. Under newest-wins, as in `fanlight serve`. One thread, which must
/// call advance() often.
class LiveFeed {
 public:
  /// The volumes must outlive the feed. The first sweep starts now.
  LiveFeed(BenchVolumes& volumes, std::int64_t sweep_ns);

  /// Lets the frames come that are due.
  void advance();

  /// Frames ahead of their volume.
  FrameQueue& frames() { return queue_; }

  /// The newest complete volume that was not taken yet; nullptr: none. Valid until the next advance().
  const Volume* complete() const { return complete_; }
  /// Whether a volume is complete, and the frame belongs to the one after it.
  bool is_for_later(const QueuedFrame& frame) const {
    return complete_ != nullptr && frame.stamp.commit_number > completed_commit_number_;
  }
  void take_complete() { complete_ = nullptr; }

 private:
  void start_sweep();

  BenchVolumes& volumes_;
  std::int64_t sweep_ns_;
  std::int64_t sweep_began_ns_;
  const Volume* arriving_ = nullptr;
  std::uint32_t arrived_ = 0;  // frames of it
  const Volume* complete_ = nullptr;
  std::uint64_t completed_commit_number_ = 0;
  Doorbell bell_;  // the caller polls
  FrameQueue queue_;
};

}  // namespace fanlight
