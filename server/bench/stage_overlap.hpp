// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "proto/model/picture.hpp"
#include "renderer/renderer.hpp"

namespace fanlight {

/// When the stages of one volume ran. `stages` is in the GPU's clock, the rest in the processor's.
struct VolumeTrace {
  std::uint64_t volume_id = 0;
  StageSpan load;
  std::array<StageSpan, kStages> stages;
  std::int64_t finished_ns = 0;
  std::int64_t complete_ns = 0;  ///< when its last frame came, in live operation; else 0
};

/// When a picture was encoded, in the processor's clock.
struct EncodingTrace {
  std::uint64_t volume_id = 0;
  StageSpan span;
};

/// The traces of the volumes of one block, in the order in which they were loaded, and of their encodings.
struct BlockTrace {
  std::vector<VolumeTrace> volumes;
  std::vector<EncodingTrace> encodings;
};

/// How far the GPU's clock is ahead of the processor's, estimated: a picture is never found before its
/// read-back has ended.
std::int64_t gpu_clock_ahead_ns(const BlockTrace& block);

/// The fraction of some spans that is covered by other spans, summed over all calls of add().
class CoveredShare {
 public:
  void add(const StageSpan& span, std::vector<StageSpan> others);
  double value() const;

 private:
  std::int64_t covered_ns_ = 0;
  std::int64_t all_ns_ = 0;
};

/// How much the stages of different volumes overlap: the fraction of the time of a stage that lies within the
/// work for other volumes.
struct StageOverlap {
  void add(const BlockTrace& block);

  CoveredShare light_in_cast;      ///< passes 2 and 3 within another volume's pass 1, first band to last
  CoveredShare light_in_work;      ///< the same within another volume's passes 0 and 1
  CoveredShare upload_in_work;     ///< copies of a volume for the GPU, within all GPU work for others
  CoveredShare read_back_in_work;  ///< copy of the picture from the GPU, likewise
  CoveredShare encoding_in_work;   ///< JPEG encoding of the picture, likewise
};

}  // namespace fanlight
