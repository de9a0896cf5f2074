// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <cstdint>

#include "acquisition/acquisition_thread.hpp"
#include "acquisition/open_source.hpp"
#include "proto/exchange/volume_ring.hpp"

namespace fanlight {

/// Reads all volumes of a source, as fast as the caller takes them.
class OfflineVolumes {
 public:
  explicit OfflineVolumes(FrameSource& source)
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
                      .ended_bell = bell_}) {}

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

  /// The volume with index `wanted`, from 0.
  Result<VolumeRing::Lease> pick(std::int64_t wanted) {
    for (std::int64_t seen = 0;; ++seen) {
      auto volume = next();
      if (!volume) return volume;
      if (!*volume) {
        return Error{
            ErrorCode::kNotFound,
            fmt::format("volume {} was asked for, but the source has {} that can be rendered, counted from 0",
                        wanted, seen)};
      }
      if (seen == wanted) return volume;
    }
  }

  const AcquisitionCounters& counters() const { return counters_; }

 private:
  Doorbell bell_;
  Doorbell writer_bell_;
  AcquisitionCounters counters_;
  VolumeRing ring_;
  AcquisitionThread acquisition_;
};

}  // namespace fanlight
