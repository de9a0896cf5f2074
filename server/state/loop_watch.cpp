// SPDX-License-Identifier: Apache-2.0
#include "server/state/loop_watch.hpp"

#include <utility>

namespace fanlight {

LoopWatch::LoopWatch(std::vector<Loop> loops, std::int64_t most_still_ns, std::int64_t now_ns)
    : most_still_ns_(most_still_ns) {
  for (Loop& loop : loops) loops_.push_back({.loop = std::move(loop), .beats = 0, .moved_ns = now_ns});
}

const LoopWatch::Loop* LoopWatch::still(std::int64_t now_ns) {
  const Loop* still = nullptr;
  for (Watched& watched : loops_) {
    const std::uint64_t beats = watched.loop.pulse->beats();
    if (std::exchange(watched.beats, beats) != beats || !watched.loop.runs()) watched.moved_ns = now_ns;
    if (still == nullptr && now_ns - watched.moved_ns > most_still_ns_) still = &watched.loop;
  }
  return still;
}

}  // namespace fanlight
