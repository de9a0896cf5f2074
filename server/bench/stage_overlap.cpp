// SPDX-License-Identifier: Apache-2.0
#include "server/bench/stage_overlap.hpp"

#include <algorithm>
#include <utility>

namespace fanlight {

namespace {

/// From the first to the last stage, both included.
using StageRange = std::pair<Stage, Stage>;

const std::vector<StageRange> kCastOnly = {{Stage::kCast, Stage::kCast}};
const std::vector<StageRange> kPrepareAndCast = {{Stage::kPrepare, Stage::kCast}};
const std::vector<StageRange> kAllGpuWork = {{Stage::kPrepare, Stage::kCast},
                                             {Stage::kFilter, Stage::kReadBack}};

const StageSpan& span_of(const VolumeTrace& volume, Stage stage) {
  return volume.stages[static_cast<std::size_t>(stage)];
}

/// The span from the begin of the first stage that ran to the end of the last one that ran. All zero if none
/// ran.
StageSpan span_of(const VolumeTrace& volume, const StageRange& range) {
  StageSpan all;
  for (auto stage = static_cast<std::size_t>(range.first); stage <= static_cast<std::size_t>(range.second);
       ++stage) {
    const StageSpan& span = volume.stages[stage];
    if (span.end_ns == 0) continue;
    if (all.end_ns == 0) all.begin_ns = span.begin_ns;
    all.end_ns = span.end_ns;
  }
  return all;
}

/// The spans of these stages of all volumes but one.
std::vector<StageSpan> spans_of_others(const BlockTrace& block, std::uint64_t volume_id,
                                       const std::vector<StageRange>& ranges) {
  std::vector<StageSpan> spans;
  for (const VolumeTrace& volume : block.volumes) {
    if (volume.volume_id == volume_id) continue;
    for (const StageRange& range : ranges) spans.push_back(span_of(volume, range));
  }
  return spans;
}

}  // namespace

std::int64_t gpu_clock_ahead_ns(const BlockTrace& block) {
  std::int64_t ahead_ns = INT64_MIN;
  for (const VolumeTrace& volume : block.volumes) {
    ahead_ns = std::max(ahead_ns, span_of(volume, Stage::kReadBack).end_ns - volume.finished_ns);
  }
  return ahead_ns;
}

void CoveredShare::add(const StageSpan& span, std::vector<StageSpan> others) {
  std::ranges::sort(others, {}, &StageSpan::begin_ns);
  std::int64_t covered_to_ns = span.begin_ns;
  for (const StageSpan& other : others) {
    const std::int64_t from_ns = std::max(other.begin_ns, covered_to_ns);
    const std::int64_t to_ns = std::min(other.end_ns, span.end_ns);
    if (to_ns <= from_ns) continue;
    covered_ns_ += to_ns - from_ns;
    covered_to_ns = to_ns;
  }
  all_ns_ += span.end_ns - span.begin_ns;
}

double CoveredShare::value() const {
  return all_ns_ == 0 ? 0 : static_cast<double>(covered_ns_) / static_cast<double>(all_ns_);
}

void StageOverlap::add(const BlockTrace& block) {
  const std::int64_t ahead_ns = gpu_clock_ahead_ns(block);
  const auto in_gpu_clock = [ahead_ns](const StageSpan& span) {
    return StageSpan{.begin_ns = span.begin_ns + ahead_ns, .end_ns = span.end_ns + ahead_ns};
  };
  for (const VolumeTrace& volume : block.volumes) {
    const StageSpan light = span_of(volume, {Stage::kFilter, Stage::kFinish});
    light_in_cast.add(light, spans_of_others(block, volume.volume_id, kCastOnly));
    light_in_work.add(light, spans_of_others(block, volume.volume_id, kPrepareAndCast));
    const auto work = spans_of_others(block, volume.volume_id, kAllGpuWork);
    upload_in_work.add(in_gpu_clock(volume.load), work);
    upload_in_work.add(span_of(volume, Stage::kUpload), work);
    read_back_in_work.add(span_of(volume, Stage::kReadBack), work);
  }
  for (const EncodingTrace& encoding : block.encodings) {
    encoding_in_work.add(in_gpu_clock(encoding.span),
                         spans_of_others(block, encoding.volume_id, kAllGpuWork));
  }
}

}  // namespace fanlight
