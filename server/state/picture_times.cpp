// SPDX-License-Identifier: Apache-2.0
#include "server/state/picture_times.hpp"

#include <algorithm>

namespace fanlight {

void TimeHistogram::add(double seconds) {
  const auto bucket = std::ranges::lower_bound(kBoundsS, seconds) - kBoundsS.begin();
  ++counts_[static_cast<std::size_t>(bucket)];
  ++count_;
  sum_s_ += seconds;
}

std::vector<std::uint64_t> TimeHistogram::cumulative() const {
  std::vector<std::uint64_t> sums;
  std::uint64_t sum = 0;
  for (const std::uint64_t count : counts_) sums.push_back(sum += count);
  return sums;
}

void PictureTimes::shown(const PictureStamp& stamp) {
  for (std::size_t stage = 0; stage < kStages; ++stage) {
    // A stage that did not run for this picture took no time.
    if (stamp.stage_ms[stage] > 0) stages_[stage].add(stamp.stage_ms[stage] / 1e3);
  }
  const std::uint64_t volume = stamp.volume.volume_id;
  if (volume <= last_volume_) return;  // the same one again, or an older one of the cine
  last_volume_ = volume;
  ages_.add(static_cast<double>(stamp.finished_time_ns - stamp.volume.last_capture_time_ns) / 1e9);
}

}  // namespace fanlight
