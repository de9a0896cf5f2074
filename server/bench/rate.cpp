// SPDX-License-Identifier: Apache-2.0
#include "server/bench/rate.hpp"

#include <cstdint>

#include "server/bench/block_runner.hpp"
#include "server/bench/rig.hpp"
#include "server/bench/work.hpp"

namespace fanlight {

Result<std::array<RateFigures, 2>> run_bench_rate(const RenderDevice& device, const BenchRow& row,
                                                  const RateBlocks& blocks) {
  constexpr std::uint32_t kVolumes = 3;
  auto work = BenchWork::create(row, kVolumes);
  if (!work) return work.error();
  BenchRig rig(device, *work);
  if (auto started = rig.start(Skipping::kOn); !started) return started.error();
  BlockRunner runner(work->volumes, rig.renderer());

  const auto sweep_ns = static_cast<std::int64_t>(1e9 / blocks.offered_hz);
  const auto with = [&](Arrival arrival) {
    return BlockSeries(
        [&runner, sweep_ns, arrival](int volumes) { return runner.live(volumes, sweep_ns, arrival); });
  };
  constexpr std::array kArrivals = {Arrival::kAtOnce, Arrival::kFrameByFrame};
  std::array ways = {with(kArrivals[0]), with(kArrivals[1])};
  for (BlockSeries& way : ways) {
    if (auto done = way.warm_up(blocks.volumes); !done) return done.error();
  }
  for (int block = 0; block < blocks.blocks; ++block) {
    for (BlockSeries& way : ways) {
      // One more: the rate is that between the first picture and the last one.
      if (auto done = way.run(blocks.volumes + 1); !done) return done.error();
    }
  }
  return std::array<RateFigures, 2>{{{.arrival = kArrivals[0], .figures = ways[0].figures()},
                                     {.arrival = kArrivals[1], .figures = ways[1].figures()}}};
}

std::span<const std::string_view> rate_rows() {
  static constexpr std::array<std::string_view, 4> kRows = {"r1/paper", "r1/coarse", "r1/default", "r2/face"};
  return kRows;
}

}  // namespace fanlight
