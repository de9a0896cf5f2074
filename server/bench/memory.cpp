// SPDX-License-Identifier: Apache-2.0
#include "server/bench/memory.hpp"

#include <algorithm>
#include <fstream>
#include <string>

#include "server/bench/rig.hpp"
#include "server/bench/run.hpp"

namespace fanlight {

namespace {

/// The value of a line of proc(5) status, "VmRSS:   350000 kB", in MB; 0 if the kernel has no such line.
double status_mb(const std::string& name) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with(name + ":")) return std::stod(line.substr(name.size() + 1)) * 1024 / 1e6;
  }
  return 0;
}

}  // namespace

Result<void> run_bench_memory(const RenderDevice& device, const BenchRow& row, std::uint64_t volumes,
                              const std::function<void(const HeldMemory&)>& tell) {
  constexpr std::uint32_t kRing = 4;
  constexpr std::uint64_t kWarmUp = 10;
  auto work = BenchWork::create(row, kRing);
  if (!work) return work.error();
  BenchRig rig(device, *work);
  if (auto started = rig.start(Skipping::kOn); !started) return started.error();
  // The renderer accepts frames ahead only for a volume that follows another one.
  if (auto first = rig.whole_volume(); !first) return first.error();
  const std::uint64_t between = std::max<std::uint64_t>((volumes - std::min(volumes, kWarmUp)) / 10, 1);
  for (std::uint64_t done = 1; done <= volumes; ++done) {
    if (auto shown = rig.new_volume(); !shown) return shown.error();
    if (done < kWarmUp || (done - kWarmUp) % between != 0) continue;
    tell({.volumes = done,
          .resident_mb = status_mb("VmRSS"),
          .own_mb = status_mb("RssAnon"),
          .ring_mb = static_cast<double>(work->volumes.held_bytes()) / 1e6});
  }
  return {};
}

}  // namespace fanlight
