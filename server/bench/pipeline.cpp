// SPDX-License-Identifier: Apache-2.0
#include "server/bench/pipeline.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <functional>
#include <utility>

#include "proto/base/clock.hpp"
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

/// Processor time of all threads of this process.
std::int64_t processor_ns() {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  const auto ns = [](const timeval& time) { return time.tv_sec * 1'000'000'000 + time.tv_usec * 1'000; };
  return ns(used.ru_utime) + ns(used.ru_stime);
}

void add_block(PipelineFigures& figures, const BlockTrace& block) {
  const EncodingTrace& first = block.encodings.front();
  const EncodingTrace& last = block.encodings.back();
  const auto place_of = [&](const EncodingTrace& encoding) {
    return std::ranges::find(block.volumes, encoding.volume_id, &VolumeTrace::volume_id) -
           block.volumes.begin();
  };
  figures.volumes_a_second.push_back(static_cast<double>(place_of(last) - place_of(first)) * 1e9 /
                                     static_cast<double>(last.span.end_ns - first.span.end_ns));
  figures.volumes += block.volumes.size();
  figures.dropped +=
      block.volumes.back().volume_id - block.volumes.front().volume_id + 1 - block.volumes.size();
  figures.encoded += block.encodings.size();
  for (const VolumeTrace& volume : block.volumes) {
    if (volume.finished_ns == 0) continue;
    ++figures.pictures;
    if (volume.complete_ns > 0)
      figures.latency_ms.push_back(static_cast<double>(volume.finished_ns - volume.complete_ns) / 1e6);
    const std::int64_t ns = volume.stages[static_cast<std::size_t>(Stage::kReadBack)].end_ns -
                            volume.stages[static_cast<std::size_t>(Stage::kCast)].end_ns;
    figures.light_ms.push_back(static_cast<double>(ns) / 1e6);
  }
}

/// One way of operation, and the time that its blocks took so far.
struct Mode {
  std::function<Result<BlockTrace>(int volumes)> run;
  PipelineFigures& figures;
  StageOverlap* overlap = nullptr;  // null: of no interest
  std::int64_t wall_ns = 0;
  std::int64_t processor_ns = 0;
};

/// Runs one block of `volumes` + 1 volumes and adds its times to the mode's.
Result<BlockTrace> run_block(Mode& mode, int volumes) {
  const std::int64_t from_ns = now_ns();
  const std::int64_t used_ns = processor_ns();
  auto block = mode.run(volumes + 1);
  if (!block) return block;
  mode.wall_ns += now_ns() - from_ns;
  mode.processor_ns += processor_ns() - used_ns;
  add_block(mode.figures, *block);
  if (mode.overlap != nullptr) mode.overlap->add(*block);
  return block;
}

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
  const auto live = [&](int count) {
    return runner.live(count, static_cast<std::int64_t>(times.sweep_ms * 1e6));
  };
  Mode modes[] = {
      {.run = [&](int count) { return runner.serial(count); }, .figures = times.serial},
      {.run = [&](int count) { return runner.pipelined(count); },
       .figures = times.pipelined,
       .overlap = &times.overlap},
      {.run = live, .figures = times.live, .overlap = &times.live_overlap},
  };
  for (Mode& mode : modes) {  // the first block of each is not counted
    const auto warm_up = mode.run(blocks.volumes + 1);
    if (!warm_up) return warm_up.error();
    if (mode.overlap == &times.overlap && !blocks.sweep_ms)
      times.sweep_ms = kSweepInPeriod * median_period_ms(*warm_up);
  }
  for (int block = 0; block < blocks.blocks; ++block) {
    for (Mode& mode : modes) {
      const auto done = run_block(mode, blocks.volumes);
      if (!done) return done.error();
      if (block + 1 == blocks.blocks) times.last_block = trace_picture(*done);
    }
  }
  for (Mode& mode : modes)
    mode.figures.busy_cores = static_cast<double>(mode.processor_ns) / static_cast<double>(mode.wall_ns);
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
  if (device.gpu->cast_queue() != device.gpu->light_queue()) {
    return "two queues of one device: passes 2 and 3 run on one of them, at the same time as pass 1 on the "
           "other";
  }
  return "one queue: bands of pass 1 and passes 2 and 3 take turns on it, at the same time as the "
         "processor's copies and "
         "encoding";
}

}  // namespace fanlight
