// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>

#include "renderer/vulkan/render_device.hpp"
#include "server/bench/process_memory.hpp"
#include "server/bench/rows.hpp"

namespace fanlight {

/// Memory of this process in MB (10^6 bytes), as the kernel counts it (proc(5), status).
struct HeldMemory {
  std::uint64_t volumes = 0;  ///< rendered so far
  double resident_mb = 0;     ///< all resident memory
  double own_mb = 0;          ///< of it, memory without a file behind it: all allocations
  double ring_mb = 0;         ///< of it, the pixels of the volumes that stand in for a ring's
};

/// Renders `volumes` volumes of a row with four different volumes in memory, as in a ring of four slots.
/// Calls `tell` after the first ten volumes and then ten times at even distances. Then adds, and notes in the
/// ledger, what a server may have besides the main view: a private view with a camera of its own, an encoder
/// of each kind, and a recorder that writes 500 frames to a folder for temporary files.
Result<void> run_bench_memory(const RenderDevice& device, const BenchRow& row, std::uint64_t volumes,
                              MemoryLedger& ledger, const std::function<void(const HeldMemory&)>& tell);

}  // namespace fanlight
