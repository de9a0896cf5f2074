// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/vulkan/render_device.hpp"
#include "server/bench/rows.hpp"
#include "server/bench/stage_overlap.hpp"

namespace fanlight {

/// Figures of one mode of operation, over all its blocks.
struct PipelineFigures {
  std::vector<double> volumes_a_second;  ///< of each block
  std::vector<double> latency_ms;  ///< of each volume in live operation: from its last frame to its picture
  std::vector<double> light_ms;    ///< of each volume: from the end of its pass 1 to the end of its read-back
  double busy_cores = 0;           ///< processor time of this process divided by wall time
  std::uint64_t volumes = 0;       ///< loaded
  std::uint64_t dropped = 0;       ///< between those, in live operation: a newer one came first
  std::uint64_t pictures = 0;      ///< rendered from these volumes
  std::uint64_t encoded = 0;       ///< of these pictures
};

/// The ways of operation of one renderer, and the overlap in two of them.
struct PipelineTimes {
  PipelineFigures serial;
  PipelineFigures pipelined;
  PipelineFigures live;
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
