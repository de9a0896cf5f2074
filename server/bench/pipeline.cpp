// SPDX-License-Identifier: Apache-2.0
#include "server/bench/pipeline.hpp"

#include <array>
#include <utility>
#include <vector>

#include "renderer/cast_means.hpp"
#include "server/bench/block_runner.hpp"
#include "server/bench/rig.hpp"
#include "server/bench/run.hpp"
#include "server/bench/stage_overlap.hpp"
#include "server/bench/trace_picture.hpp"
#include "server/bench/work.hpp"

namespace fanlight {

namespace {

// Duration of a sweep of the live probe, as a share of the time that a volume takes in pipelined operation.
constexpr double kSweepInPeriod = 0.75;

double median_period_ms(const BlockTrace& block) {
  std::vector<double> period_ms;
  for (std::size_t volume = 1; volume < block.volumes.size(); ++volume) {
    const std::int64_t ns = block.volumes[volume].finished_ns - block.volumes[volume - 1].finished_ns;
    period_ms.push_back(static_cast<double>(ns) / 1e6);
  }
  return quantile(std::move(period_ms), 0.5);
}

Result<PipelineTimes> run_blocks(BlockRunner& runner, const PipelineBlocks& blocks) {
  PipelineTimes times{.sweep_ms = blocks.sweep_ms.value_or(0)};
  const auto as_probe = [&](int count) {
    return runner.live(count, static_cast<std::int64_t>(times.sweep_ms * 1e6));
  };
  BlockSeries serial([&](int count) { return runner.serial(count); });
  BlockSeries pipelined([&](int count) { return runner.pipelined(count); }, &times.overlap);
  BlockSeries live(as_probe, &times.live_overlap);
  BlockSeries* const ways[] = {&serial, &pipelined, &live};
  for (BlockSeries* const way : ways) {
    // One more volume than is counted.
    const auto warm_up = way->warm_up(blocks.volumes + 1);
    if (!warm_up) return warm_up.error();
    if (way == &pipelined && !blocks.sweep_ms) times.sweep_ms = kSweepInPeriod * median_period_ms(*warm_up);
  }
  for (int block = 0; block < blocks.blocks; ++block) {
    for (BlockSeries* const way : ways) {
      const auto done = way->run(blocks.volumes + 1);
      if (!done) return done.error();
      if (block + 1 == blocks.blocks) times.last_block = trace_picture(*done);
    }
  }
  times.serial = serial.figures();
  times.pipelined = pipelined.figures();
  times.live = live.figures();
  return times;
}

}  // namespace

Result<PipelineTimes> run_bench_pipeline(const RenderDevice& device, const BenchRow& row,
                                         const PipelineBlocks& blocks) {
  constexpr std::uint32_t kVolumes = 3;
  auto work = BenchWork::create(row, kVolumes);
  if (!work) return work.error();
  BenchRig rig(device, *work);
  if (auto started = rig.start(Skipping::kOn); !started) return started.error();
  BlockRunner runner(work->volumes, rig.renderer());
  return run_blocks(runner, blocks);
}

std::span<const std::string_view> pipeline_rows() {
  static constexpr std::array<std::string_view, 3> kRows = {"r1/default", "r1/paper", "r1/paper/raw"};
  return kRows;
}

std::string_view pipeline_mechanism(const RenderDevice& device) {
  if (device.light_gpu) {
    return "two devices of one processor: passes 2 and 3 run on one of them, at the same time as pass 1 on "
           "the other";
  }
  const bool is_processor = device.gpu->candidate().kind == kProcessorKind;
  if (is_processor && !live_device_options().own_light_device) {
    return "one processor: its threads run all passes in turn, at the same time as encoding";
  }
  if (device.gpu->cast_queue() != device.gpu->light_queue()) {
    return "two queues of one device: passes 2 and 3 run on one of them, at the same time as pass 1 on the "
           "other";
  }
  return "one queue: bands of pass 1 and passes 2 and 3 take turns on it, at the same time as the "
         "processor's copies and "
         "encoding";
}

}  // namespace fanlight
