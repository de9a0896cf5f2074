#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "renderer/gpu.hpp"
#include "server/bench_rows.hpp"

namespace fanlight {

/// What one way of operation did, over all its blocks.
struct PipelineFigures {
  std::vector<double> volumes_a_second;  ///< of each block
  std::vector<double> light_ms;  ///< of each volume: from the end of its pass 1 to its picture read back
  double busy_cores = 0;         ///< processor time of this process over time
  std::uint64_t volumes = 0;     ///< loaded
  std::uint64_t pictures = 0;    ///< that came of them
  std::uint64_t encoded = 0;     ///< of these
};

/// Serial and pipelined operation of one renderer, and what overlapped in the latter: shares of the time of
/// what is named that lay within what other volumes were at.
struct PipelineTimes {
  PipelineFigures serial;
  PipelineFigures pipelined;
  double light_in_cast = 0;   ///< passes 2 and 3 within another volume's pass 1, first band to last
  double light_in_work = 0;   ///< the same within another's passes 0 and 1
  double upload_in_work = 0;  ///< the copy to where the GPU fetches it within all that the GPU did for others
  double read_back_in_work = 0;  ///< the picture's copy, likewise
  double encoding_in_work = 0;   ///< its JPEG, likewise
};

/// Runs blocks of serial and of pipelined operation in turn, `blocks` of each after one of each that counts
/// nothing. Serial: a volume is loaded, rendered and encoded before the next one is. Pipelined: the renderer
/// takes a volume whenever it wants one, and another thread encodes the pictures. A block is timed from its
/// first picture's JPEG to its last one's, `volumes` later.
Result<PipelineTimes> run_bench_pipeline(const Gpu& gpu, const BenchRow& row, int blocks, int volumes);

/// The rows that `fanlight bench pipeline` runs unless told.
std::span<const std::string_view> pipeline_rows();

/// One sentence: what can run side by side on this GPU.
std::string_view pipeline_mechanism(const Gpu& gpu);

}  // namespace fanlight
