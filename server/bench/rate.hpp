// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "proto/base/result.hpp"
#include "renderer/vulkan/render_device.hpp"
#include "server/bench/block_series.hpp"
#include "server/bench/live_feed.hpp"
#include "server/bench/rows.hpp"

namespace fanlight {

/// How many volumes a second become pictures, where a source delivers them in one way.
struct RateFigures {
  Arrival arrival = Arrival::kAtOnce;
  BlockFigures figures;
};

struct RateBlocks {
  double offered_hz = 0;  ///< sweeps a second that the source delivers
  int blocks = 0;         ///< of each way
  int volumes = 0;        ///< rendered in a block
};

/// Renders a row as `fanlight serve` does, with a source that delivers sweeps at a fixed rate in both ways,
/// block by block in turn. The newest sweep wins, and another thread encodes the pictures as JPEG. The first
/// block of each way is not counted.
Result<std::array<RateFigures, 2>> run_bench_rate(const RenderDevice& device, const BenchRow& row,
                                                  const RateBlocks& blocks);

/// The rows that `fanlight bench rate` runs by default.
std::span<const std::string_view> rate_rows();

}  // namespace fanlight
