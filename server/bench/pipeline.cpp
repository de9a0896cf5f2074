// SPDX-License-Identifier: Apache-2.0
#include "server/bench/pipeline.hpp"

#include <sys/resource.h>

#include <array>

#include "proto/base/clock.hpp"
#include "server/bench/block_runner.hpp"
#include "server/bench/rig.hpp"
#include "server/bench/stage_overlap.hpp"
#include "server/bench/trace_picture.hpp"
#include "server/bench/work.hpp"

namespace fanlight {

namespace {

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
  figures.volumes_a_second.push_back(static_cast<double>(last.volume_id - first.volume_id) * 1e9 /
                                     static_cast<double>(last.span.end_ns - first.span.end_ns));
  figures.volumes += block.volumes.size();
  figures.encoded += block.encodings.size();
  for (const VolumeTrace& volume : block.volumes) {
    if (volume.finished_ns == 0) continue;
    ++figures.pictures;
    const std::int64_t ns = volume.stages[static_cast<std::size_t>(Stage::kReadBack)].end_ns -
                            volume.stages[static_cast<std::size_t>(Stage::kCast)].end_ns;
    figures.light_ms.push_back(static_cast<double>(ns) / 1e6);
  }
}

/// One way of operation, and the time that its blocks took so far.
struct Mode {
  Result<BlockTrace> (BlockRunner::*run)(int volumes);
  PipelineFigures& figures;
  std::int64_t wall_ns = 0;
  std::int64_t processor_ns = 0;
};

/// Runs one block of `volumes` + 1 volumes and adds its times to the mode's.
Result<BlockTrace> run_block(BlockRunner& runner, Mode& mode, int volumes) {
  const std::int64_t from_ns = now_ns();
  const std::int64_t used_ns = processor_ns();
  auto block = (runner.*mode.run)(volumes + 1);
  if (!block) return block;
  mode.wall_ns += now_ns() - from_ns;
  mode.processor_ns += processor_ns() - used_ns;
  add_block(mode.figures, *block);
  return block;
}

Result<PipelineTimes> run_blocks(BlockRunner& runner, int blocks, int volumes) {
  PipelineTimes times;
  StageOverlap overlap;
  Mode serial{.run = &BlockRunner::serial, .figures = times.serial};
  Mode pipelined{.run = &BlockRunner::pipelined, .figures = times.pipelined};
  for (Mode* const mode : {&serial, &pipelined}) {  // the first block of each is not counted
    if (auto warm_up = (runner.*mode->run)(volumes + 1); !warm_up) return warm_up.error();
  }
  for (int block = 0; block < blocks; ++block) {
    if (auto done = run_block(runner, serial, volumes); !done) return done.error();
    const auto done = run_block(runner, pipelined, volumes);
    if (!done) return done.error();
    overlap.add(*done);
    if (block + 1 == blocks) times.last_block = trace_picture(*done);
  }
  for (Mode* const mode : {&serial, &pipelined}) {
    mode->figures.busy_cores = static_cast<double>(mode->processor_ns) / static_cast<double>(mode->wall_ns);
  }
  overlap.write_to(times);
  return times;
}

}  // namespace

Result<PipelineTimes> run_bench_pipeline(const RenderDevice& device, const BenchRow& row, int blocks,
                                         int volumes) {
  constexpr std::uint32_t kVolumes = 3;
  auto work = BenchWork::create(row, kVolumes);
  if (!work) return work.error();
  BenchRig rig(device, *work);
  if (auto started = rig.start(Skipping::kOn); !started) return started.error();
  BlockRunner runner(work->volumes, rig.renderer());
  return run_blocks(runner, blocks, volumes);
}

std::span<const std::string_view> pipeline_rows() {
  static constexpr std::array<std::string_view, 2> kRows = {"r1/default", "r1/paper"};
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
