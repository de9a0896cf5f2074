// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "acquisition/acquisition_thread.hpp"
#include "acquisition/open_source.hpp"
#include "proto/exchange/volume_ring.hpp"

namespace fanlight {

/// Reads all volumes of a source, as fast as the caller takes them.
class OfflineVolumes {
 public:
  explicit OfflineVolumes(FrameSource& source) : OfflineVolumes(source, MismatchCorrection::kOn, {}) {}

  /// With the corrections that the volumes of a recording had when it was made.
  OfflineVolumes(FrameSource& source, std::span<const RecordedCorrection> recorded)
      : OfflineVolumes(source, MismatchCorrection::kOff, recorded) {}

  OfflineVolumes(FrameSource& source, MismatchCorrection correction,
                 std::span<const RecordedCorrection> recorded)
      : ring_({.geometry = source.description().geometry,
               .frame_capacity = source.description().frames_per_volume,
               .slots = 3,
               .policy = RingPolicy::kProcessAll,
               .largest_frame_bytes = source.description().largest_frame_bytes},
              {.reader_bell = bell_, .writer_bell = writer_bell_}),
        acquisition_({.source = source,
                      .ring = ring_,
                      .writer_bell = writer_bell_,
                      .counters = counters_,
                      .ended_bell = bell_,
                      .dropped = &queue_,
                      .recorded = recorded},
                     correction) {}

  /// The next volume, valid as long as this object; an empty lease at the end of the source. Blocks.
  Result<VolumeRing::Lease> next() {
    for (;;) {
      // Read before the ring, so that a volume published before the end is not missed.
      const auto state = acquisition_.state();
      if (auto volume = ring_.take()) return volume;
      if (state == AcquisitionThread::State::kFailed) return acquisition_.error();
      if (state != AcquisitionThread::State::kRunning) return VolumeRing::Lease();
      bell_.wait(-1);
    }
  }

  /// The volume with the source's own number `wanted`; without one, the first that the source gives.
  /// kNotFound: the source has no such volume, or dropped its sweep; the message says why.
  Result<VolumeRing::Lease> pick(std::optional<std::uint64_t> wanted) {
    std::optional<std::uint64_t> first;
    std::optional<std::uint64_t> last;
    for (;;) {
      auto volume = next();
      if (!volume) return volume;
      if (!*volume) break;
      dropped();  // before its queue is full
      const std::uint64_t number = (*volume)->stamp().source_volume_index;
      if (!first) first = number;
      last = number;
      if (!wanted || number == *wanted) return volume;
      if (number > *wanted) break;
    }
    return not_found(wanted, first, last);
  }

  /// The sweeps that were dropped so far.
  const std::vector<DroppedSweep>& dropped() {
    while (const auto sweep = queue_.take()) dropped_.push_back(*sweep);
    return dropped_;
  }

  const AcquisitionCounters& counters() const { return counters_; }

 private:
  Error not_found(std::optional<std::uint64_t> wanted, std::optional<std::uint64_t> first,
                  std::optional<std::uint64_t> last) {
    const auto& sweeps = dropped();
    const auto found = std::ranges::find_if(
        sweeps, [&](const DroppedSweep& sweep) { return !wanted || sweep.volume_index == *wanted; });
    if (found != sweeps.end()) {
      return {ErrorCode::kNotFound,
              fmt::format("volume {} was dropped: {}", found->volume_index, reason_of(*found))};
    }
    if (!wanted || !first)
      return {ErrorCode::kNotFound, "the source has no volume that can be rendered, expected one at least"};
    if (*last > *wanted) {
      return {ErrorCode::kNotFound,
              fmt::format("there is no volume {}, expected one of the source's numbers; "
                          "the first is {}, the next after it {}",
                          *wanted, *first, *last)};
    }
    return {ErrorCode::kNotFound,
            fmt::format("there is no volume {}, expected one of {} to {}", *wanted, *first, *last)};
  }

  Doorbell bell_;
  Doorbell writer_bell_;
  AcquisitionCounters counters_;
  DroppedSweeps queue_;
  std::vector<DroppedSweep> dropped_;
  VolumeRing ring_;
  AcquisitionThread acquisition_;
};

}  // namespace fanlight
