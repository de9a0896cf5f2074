// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "acquisition/source/frame_source.hpp"
#include "proto/exchange/frame_queue.hpp"
#include "proto/model/volume.hpp"
#include "server/bench/rows.hpp"

namespace fanlight {

/// The first volumes of a source, repeated as if they were new. Each repetition has new volume and commit
/// numbers, and comes to a slot of the renderer that had another volume last, so that no result of an earlier
/// one can be used again. The pixels are not copied.
class BenchVolumes {
 public:
  /// Reads `count` volumes of the source of the row, at least three. Where it has fewer, the others are
  /// copies, each a grey level brighter. Errors: those of open_source(), or a source without volumes.
  static Result<BenchVolumes> create(const BenchRow& row, std::uint32_t count);

  const SourceDescription& description() const { return description_; }
  std::uint32_t frame_capacity() const;
  std::size_t held_bytes() const;  ///< of the pixels of all volumes

  /// The next volume with all its frames. Valid until the second next call.
  const Volume& next();

  /// A frame of the volume that next() returned last, as the frame queue passes it on. `index` is in the
  /// order of reception.
  QueuedFrame frame(std::uint32_t index) const;

 private:
  struct Kept {
    std::vector<FrameStamp> stamps;
    Volume volume;
  };
  static Kept brighter(const Kept& from);
  BenchVolumes(const SourceDescription& description, std::vector<Kept> kept)
      : description_(description), kept_(std::move(kept)) {}

  SourceDescription description_;
  std::vector<Kept> kept_;
  std::uint64_t shown_ = 0;
  std::uint64_t commit_numbers_ = 0;
};

}  // namespace fanlight
