// SPDX-License-Identifier: Apache-2.0
#include "server/bench/process_memory.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>

namespace fanlight {

namespace {

/// The number in a line of proc(5), "VmRSS:   350000 kB", in MB; 0 if there is none.
double line_mb(std::string_view line) {
  const std::size_t digit = line.find_first_of("0123456789");
  double kib = 0;
  if (digit != std::string_view::npos) std::from_chars(line.data() + digit, line.data() + line.size(), kib);
  return kib * 1024 / 1e6;
}

/// The value of a line of /proc/self/status in MB; 0 if the kernel has no such line.
double status_mb(const std::string& name) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with(name + ":")) return line_mb(line);
  }
  return 0;
}

}  // namespace

double resident_mb() {
  return status_mb("VmRSS");
}

double own_mb() {
  return status_mb("RssAnon") + status_mb("RssShmem");
}

void MemoryLedger::note(std::string_view step) {
  const double now_mb = own_mb();
  parts_.push_back({step, now_mb - noted_mb_});
  noted_mb_ = now_mb;
}

std::vector<MemoryPart> file_pages() {
  enum : std::uint8_t { kProgram, kDriver, kLibraries };
  // Mesa's drivers and their compiler, and NVIDIA's.
  constexpr std::array<std::string_view, 4> kDriverNames = {"libLLVM", "/libvulkan_", "nvidia", "libcuda"};
  std::vector<MemoryPart> parts = {
      {"pages of the program"}, {"pages of the driver and its compiler"}, {"pages of other libraries"}};
  std::error_code unknown;
  const std::string program = std::filesystem::read_symlink("/proc/self/exe", unknown).string();
  std::ifstream maps("/proc/self/smaps");
  auto kind = kLibraries;
  bool of_file = false;
  double rss_mb = 0;
  for (std::string line; std::getline(maps, line);) {
    // "00400000-0048a000 r-xp 00000000 fd:03 960637  /usr/lib/libLLVM-15.so.1", then a line for each count.
    const bool head = !line.empty() && (std::isdigit(line[0]) != 0 || std::islower(line[0]) != 0);
    if (head) {
      const std::size_t slash = line.find('/');
      of_file = slash != std::string::npos && !line.ends_with("(deleted)");
      const std::string_view path = of_file ? std::string_view(line).substr(slash) : std::string_view();
      const bool driver = std::ranges::any_of(
          kDriverNames, [&](std::string_view name) { return path.find(name) != std::string_view::npos; });
      kind = path == program ? kProgram : driver ? kDriver : kLibraries;
    } else if (of_file && line.starts_with("Rss:")) {
      rss_mb = line_mb(line);
    } else if (of_file && line.starts_with("Anonymous:")) {
      // Written pages of a file are memory of this process.
      parts[kind].mb += rss_mb - line_mb(line);
    }
  }
  return parts;
}

}  // namespace fanlight
