// SPDX-License-Identifier: Apache-2.0
#include "server/bench/block_series.hpp"

#include <sys/resource.h>

#include <algorithm>

#include "proto/base/clock.hpp"

namespace fanlight {

namespace {

/// Processor time of all threads of this process.
std::int64_t processor_ns() {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  const auto ns = [](const timeval& time) { return time.tv_sec * 1'000'000'000 + time.tv_usec * 1'000; };
  return ns(used.ru_utime) + ns(used.ru_stime);
}

}  // namespace

void BlockSeries::add(const BlockTrace& block) {
  const EncodingTrace& first = block.encodings.front();
  const EncodingTrace& last = block.encodings.back();
  const auto place_of = [&](const EncodingTrace& encoding) {
    return std::ranges::find(block.volumes, encoding.volume_id, &VolumeTrace::volume_id) -
           block.volumes.begin();
  };
  // One picture alone has no rate.
  if (first.volume_id != last.volume_id) {
    figures_.volumes_a_second.push_back(static_cast<double>(place_of(last) - place_of(first)) * 1e9 /
                                        static_cast<double>(last.span.end_ns - first.span.end_ns));
  }
  figures_.volumes += block.volumes.size();
  figures_.dropped +=
      block.volumes.back().volume_id - block.volumes.front().volume_id + 1 - block.volumes.size();
  figures_.encoded += block.encodings.size();
  for (const VolumeTrace& volume : block.volumes) {
    if (volume.finished_ns == 0) continue;
    ++figures_.pictures;
    if (volume.complete_ns > 0)
      figures_.latency_ms.push_back(static_cast<double>(volume.finished_ns - volume.complete_ns) / 1e6);
    const std::int64_t ns = volume.stages[static_cast<std::size_t>(Stage::kReadBack)].end_ns -
                            volume.stages[static_cast<std::size_t>(Stage::kCast)].end_ns;
    figures_.light_ms.push_back(static_cast<double>(ns) / 1e6);
  }
}

Result<BlockTrace> BlockSeries::run(int volumes) {
  const std::int64_t from_ns = now_ns();
  const std::int64_t used_ns = processor_ns();
  auto block = run_(volumes);
  if (!block) return block;
  wall_ns_ += now_ns() - from_ns;
  processor_ns_ += processor_ns() - used_ns;
  add(*block);
  if (overlap_ != nullptr) overlap_->add(*block);
  return block;
}

BlockFigures BlockSeries::figures() const {
  BlockFigures figures = figures_;
  figures.busy_cores = static_cast<double>(processor_ns_) / static_cast<double>(wall_ns_);
  return figures;
}

}  // namespace fanlight
