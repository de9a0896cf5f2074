// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "proto/base/result.hpp"
#include "server/bench/stage_overlap.hpp"

namespace fanlight {

/// Figures of one way of operation, over all its blocks.
struct BlockFigures {
  std::vector<double> volumes_a_second;  ///< of each block
  std::vector<double> latency_ms;  ///< of each volume in live operation: from its last frame to its picture
  std::vector<double> light_ms;    ///< of each volume: from the end of its pass 1 to the end of its read-back
  double busy_cores = 0;           ///< processor time of this process divided by wall time
  std::uint64_t volumes = 0;       ///< loaded
  std::uint64_t dropped = 0;       ///< between those, in live operation: a newer one came first
  std::uint64_t pictures = 0;      ///< rendered from these volumes
  std::uint64_t encoded = 0;       ///< of these pictures
};

/// Blocks of volumes in one way of operation, and their figures.
class BlockSeries {
 public:
  using Run = std::function<Result<BlockTrace>(int volumes)>;
  /// `overlap`: to which the blocks are added; null: of no interest. It must outlive the series.
  explicit BlockSeries(Run run, StageOverlap* overlap = nullptr) : run_(std::move(run)), overlap_(overlap) {}

  /// Runs one block that is not counted.
  Result<BlockTrace> warm_up(int volumes) { return run_(volumes); }
  /// Runs one block and adds its times.
  Result<BlockTrace> run(int volumes);

  /// Of the blocks that were run.
  BlockFigures figures() const;

 private:
  void add(const BlockTrace& block);

  Run run_;
  StageOverlap* overlap_;
  BlockFigures figures_;
  std::int64_t wall_ns_ = 0;
  std::int64_t processor_ns_ = 0;
};

}  // namespace fanlight
