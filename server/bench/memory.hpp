// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string_view>
#include <vector>

#include "renderer/vulkan/render_device.hpp"
#include "server/bench/rows.hpp"

namespace fanlight {

/// Memory of this process in MB (10^6 bytes), as the kernel counts it (proc(5), status).
struct HeldMemory {
  std::uint64_t volumes = 0;  ///< rendered so far
  double resident_mb = 0;     ///< all resident memory
  double own_mb = 0;          ///< of it, memory without a file behind it: all allocations
  double ring_mb = 0;         ///< of it, the pixels of the volumes that stand in for a ring's
};

/// A part of the resident memory of this process.
struct MemoryPart {
  std::string_view name;
  double mb = 0;  ///< 10^6 bytes
};

/// By how much each step has raised the memory of this process without a file behind it. Memory that a step
/// has freed, and that a later one uses again, is counted for the first of them.
class MemoryLedger {
 public:
  /// What was allocated so far is the first part.
  MemoryLedger() { note("start of the program"); }
  void note(std::string_view step);
  const std::vector<MemoryPart>& parts() const { return parts_; }

 private:
  double noted_mb_ = 0;
  std::vector<MemoryPart> parts_;
};

/// Resident pages of files: of the program, of the driver (with its compiler, LLVM), and of all other
/// libraries.
std::vector<MemoryPart> file_pages();

/// Renders `volumes` volumes of a row with four different volumes in memory, as in a ring of four slots.
/// Calls `tell` after the first ten volumes and then ten times at even distances. Then adds, and notes in the
/// ledger, what a server may have besides the main view: a private view with a camera of its own, an encoder
/// of each kind, and a recorder that writes 500 frames to a folder for temporary files.
Result<void> run_bench_memory(const RenderDevice& device, const BenchRow& row, std::uint64_t volumes,
                              MemoryLedger& ledger, const std::function<void(const HeldMemory&)>& tell);

}  // namespace fanlight
