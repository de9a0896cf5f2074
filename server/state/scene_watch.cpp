// SPDX-License-Identifier: Apache-2.0
#include "server/state/scene_watch.hpp"

#include <algorithm>
#include <utility>

namespace fanlight {

namespace {

// Of a hand that moves, more are joined to the newest one.
constexpr std::size_t kMostWaiting = 256;

}  // namespace

void SceneWatch::follow(const Situation& now, std::int64_t now_ns) {
  const std::int64_t gap_ns = now_ns - std::exchange(last_ns_, now_ns);
  if (std::exchange(newest_, now.in_force) != now.in_force) {
    if (waiting_.size() < kMostWaiting) {
      waiting_.push_back({.revision = now.in_force, .since_ns = now_ns});
    } else {
      waiting_.back().revision = now.in_force;
    }
  }
  while (!waiting_.empty() && waiting_.front().revision <= now.shown) waiting_.pop_front();
  // Neither time without pictures counts, nor that of a process that was stopped.
  constexpr std::int64_t kMostGapNs = 2'000'000'000;
  const std::int64_t left_out_ns =
      now.are_pictures_expected ? std::max<std::int64_t>(gap_ns - kMostGapNs, 0) : gap_ns;
  for (Change& each : waiting_) each.since_ns += std::min(left_out_ns, now_ns - each.since_ns);
}

SceneWatch::Event SceneWatch::update(const Situation& now, std::int64_t now_ns) {
  follow(now, now_ns);
  const std::int64_t waited_ns = waiting_.empty() ? 0 : now_ns - waiting_.front().since_ns;
  const bool was_overdue = std::exchange(overdue_, waited_ns > kPatienceNs);
  if (!overdue_) return Event::kNone;
  if (waited_ns > kWithdrawalNs && now.refused > now.shown) {
    waiting_.clear();
    overdue_ = false;
    return Event::kWithdrawn;
  }
  return was_overdue ? Event::kNone : Event::kNotShown;
}

}  // namespace fanlight
