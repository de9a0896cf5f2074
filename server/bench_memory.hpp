#pragma once

#include <cstdint>
#include <functional>

#include "renderer/gpu.hpp"
#include "server/bench_rows.hpp"

namespace fanlight {

/// What this process holds, in MB (10^6 bytes), as the kernel counts it (proc(5), status).
struct HeldMemory {
  std::uint64_t volumes = 0;  ///< rendered before
  double resident_mb = 0;     ///< of all kinds
  double own_mb = 0;          ///< of it, what is backed by no file: all that is allocated
  double ring_mb = 0;         ///< of it, the pixels of the volumes that stand for a ring's
};

/// Renders `volumes` volumes of a row, of which four are held, as in a ring of four, and tells of the memory
/// after the first ten and then ten times, evenly spread.
Result<void> run_bench_memory(const Gpu& gpu, const BenchRow& row, std::uint64_t volumes,
                              const std::function<void(const HeldMemory&)>& tell);

}  // namespace fanlight
