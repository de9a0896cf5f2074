// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/vulkan/render_device.hpp"
#include "server/bench/rows.hpp"

namespace fanlight {

/// Figures of one mode of operation, over all its blocks.
struct PipelineFigures {
  std::vector<double> volumes_a_second;  ///< of each block
  std::vector<double> light_ms;  ///< of each volume: from the end of its pass 1 to the end of its read-back
  double busy_cores = 0;         ///< processor time of this process divided by wall time
  std::uint64_t volumes = 0;     ///< loaded
  std::uint64_t pictures = 0;    ///< rendered from these volumes
  std::uint64_t encoded = 0;     ///< of these pictures
};

/// Serial and pipelined operation of one renderer, and the overlap in the latter: the fraction of the time of
/// a stage that lies within the work for other volumes.
struct PipelineTimes {
  PipelineFigures serial;
  PipelineFigures pipelined;
  double light_in_cast = 0;      ///< passes 2 and 3 within another volume's pass 1, first band to last
  double light_in_work = 0;      ///< the same within another volume's passes 0 and 1
  double upload_in_work = 0;     ///< copies of a volume for the GPU, within all GPU work for others
  double read_back_in_work = 0;  ///< copy of the picture from the GPU, likewise
  double encoding_in_work = 0;   ///< JPEG encoding of the picture, likewise
  std::string last_block;        ///< trace_picture() of the last pipelined block
};

/// Runs blocks of serial and of pipelined operation in turn, `blocks` of each after a first one of each that
/// is not counted. Serial: a volume is loaded, rendered and encoded before the next one is loaded. Pipelined:
/// the renderer gets a volume whenever it wants one, and another thread encodes the pictures. A block is
/// timed from the end of its first picture's encoding to the end of its last one's, `volumes` volumes later.
Result<PipelineTimes> run_bench_pipeline(const RenderDevice& device, const BenchRow& row, int blocks,
                                         int volumes);

/// The rows that `fanlight bench pipeline` runs by default.
std::span<const std::string_view> pipeline_rows();

/// One sentence: what can run at the same time on this GPU.
std::string_view pipeline_mechanism(const RenderDevice& device);

}  // namespace fanlight
