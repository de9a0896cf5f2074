// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "proto/base/result.hpp"
#include "proto/exchange/frame_queue.hpp"
#include "proto/model/volume.hpp"
#include "server/bench/volumes.hpp"

namespace fanlight {

/// How the frames of a sweep come: one after the other, at equal intervals, as from a probe; or all with the
/// last one.
enum class Arrival : std::uint8_t { kFrameByFrame, kAtOnce };

/// Volumes as from a live source, complete with the last frame of each sweep. Under newest-wins, as in
/// `fanlight serve`. One thread, which must call advance() often.
class LiveFeed {
 public:
  /// The volumes must outlive the feed. The first sweep starts now.
  LiveFeed(BenchVolumes& volumes, std::int64_t sweep_ns, Arrival arrival = Arrival::kFrameByFrame);

  /// Lets the frames come that are due.
  void advance();

  /// Frames ahead of their volume; none where they come at once.
  FrameQueue& frames() { return queue_; }

  /// The newest complete volume that was not taken yet; nullptr: none. Valid until the next advance().
  const Volume* complete() const { return complete_; }
  /// As VolumeRing::waiting_commit_number().
  std::optional<std::uint64_t> waiting_commit_number() const {
    return complete_ != nullptr ? std::optional(completed_commit_number_) : std::nullopt;
  }
  void take_complete() { complete_ = nullptr; }
  std::int64_t completed_ns() const { return completed_ns_; }  ///< when complete() was

 private:
  void start_sweep();

  BenchVolumes& volumes_;
  std::int64_t sweep_ns_;
  Arrival arrival_;
  std::int64_t sweep_began_ns_;
  const Volume* arriving_ = nullptr;
  std::uint32_t arrived_ = 0;  // frames of it
  const Volume* complete_ = nullptr;
  std::uint64_t completed_commit_number_ = 0;
  std::int64_t completed_ns_ = 0;
  Doorbell bell_;  // the caller polls
  FrameQueue queue_;
};

}  // namespace fanlight
