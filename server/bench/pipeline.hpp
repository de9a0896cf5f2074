// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "renderer/vulkan/render_device.hpp"
#include "server/bench/block_series.hpp"
#include "server/bench/rows.hpp"
#include "server/bench/stage_overlap.hpp"

namespace fanlight {

/// The ways of operation of one renderer, and the overlap in two of them.
struct PipelineTimes {
  BlockFigures serial;
  BlockFigures pipelined;
  BlockFigures live;
  StageOverlap overlap;       ///< pipelined
  StageOverlap live_overlap;  ///< live
  double sweep_ms = 0;        ///< of the live probe
  std::string last_block;     ///< trace_picture() of the last live block
};

struct PipelineBlocks {
  int blocks = 0;   ///< of each way of operation
  int volumes = 0;  ///< in a block
  /// Duration of a sweep of the live probe; absent: 0.75 of the time of a volume in pipelined operation, so
  /// that volumes come faster than they are rendered.
  std::optional<double> sweep_ms{};
};

/// Runs blocks of serial, pipelined and live operation in turn, after a first one of each that is not
/// counted. Serial: a volume is loaded, rendered and encoded before the next one is loaded. Pipelined: the
/// renderer gets a whole volume whenever it wants one, and another thread encodes the pictures. Live: the
/// same, but the frames come one after the other, as from a probe (LiveFeed). A block is timed from the end
/// of its first picture's encoding to the end of its last one's.
Result<PipelineTimes> run_bench_pipeline(const RenderDevice& device, const BenchRow& row,
                                         const PipelineBlocks& blocks);

/// The rows that `fanlight bench pipeline` runs by default.
std::span<const std::string_view> pipeline_rows();

/// One sentence: what can run at the same time on this GPU.
std::string_view pipeline_mechanism(const RenderDevice& device);

}  // namespace fanlight
