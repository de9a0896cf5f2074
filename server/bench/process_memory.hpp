// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>
#include <vector>

namespace fanlight {

// Memory of this process in MB (10^6 bytes), as the kernel counts it (proc(5), status and smaps). Any thread.

/// All resident memory.
double resident_mb();

/// Resident memory without a file behind it: all allocations. Mesa 25 allocates the memory of its devices in
/// files that have no name; they count too.
double own_mb();

/// A part of the resident memory.
struct MemoryPart {
  std::string_view name;
  double mb = 0;
};

/// Resident pages of files: of the program, of the driver (with its compiler, LLVM), and of all other
/// libraries.
std::vector<MemoryPart> file_pages();

/// By how much each step has raised own_mb(). Memory that a step has freed, and that a later one uses again,
/// is counted for the first of them.
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

}  // namespace fanlight
