#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "acquisition/frame_source.hpp"
#include "proto/frame_feed.hpp"
#include "proto/volume.hpp"
#include "server/bench_rows.hpp"

namespace fanlight {

/// The first volumes of a source, shown over and over as if they had just come: each time with numbers of its
/// own, so that nothing that was kept of the last time stands in for work. Their pixels are not copied for
/// it.
class BenchVolumes {
 public:
  /// Reads `count` volumes of the row's source. Errors: those of open_source(), or a source with none.
  static Result<BenchVolumes> create(const BenchRow& row, std::uint32_t count);

  const SourceDescription& description() const { return description_; }
  std::uint32_t frame_capacity() const;
  std::size_t held_bytes() const;  ///< of pixels

  /// The next volume, with all frames in it; valid until the next call.
  const Volume& next();

  /// The frames of the volume that next() gave last, one by one, in order of arrival, as a feed hands them
  /// on.
  FedFrame frame(std::uint32_t index) const;

 private:
  struct Kept {
    std::vector<FrameStamp> stamps;
    Volume volume;
  };
  BenchVolumes(const SourceDescription& description, std::vector<Kept> kept)
      : description_(description), kept_(std::move(kept)) {}

  SourceDescription description_;
  std::vector<Kept> kept_;
  std::uint64_t shown_ = 0;
  std::uint64_t arrivals_ = 0;
};

}  // namespace fanlight
