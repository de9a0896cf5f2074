// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "renderer/vulkan/render_device.hpp"
#include "server/bench/machine_limits.hpp"
#include "server/bench/rows.hpp"

namespace fanlight {

/// A pass, and the least time that this machine could need for it.
struct PassLimit {
  std::string pass;         ///< "prepare"
  double ms = 0;            ///< median of the rounds
  std::uint64_t items = 0;  ///< that it works on
  std::string item;         ///< "voxels"
  double item_bytes = 0;    ///< that have to be read and written for each, once
  double item_gathers = 0;  ///< words that have to be gathered for each
  double item_ns = 0;       ///< of one processor, for each
  double item_cycles = 0;   ///< the same
  double memory_ms = 0;     ///< for the bytes, at the speed of the memory
  double gather_ms = 0;     ///< for the words, as fast as they are gathered near one another

  /// How many times longer the pass takes than it could; 0 where it has nothing to do.
  double times_the_least() const {
    const double least_ms = std::max(memory_ms, gather_ms);
    return least_ms > 0 ? ms / least_ms : 0;
  }
};

/// How far each pass of a row is from what the machine can do, for volumes that come at once. The least time
/// counts bytes and gathered words alone: what is computed with them comes in addition.
struct RowLimits {
  std::vector<PassLimit> passes;
  double sampled_share = 1;  ///< samples that are read, of those without skipping
};

/// One round is not counted. Error: as BenchRig.
Result<RowLimits> run_bench_limit(const RenderDevice& device, const MachineLimits& machine,
                                  const BenchRow& row, int rounds);

}  // namespace fanlight
