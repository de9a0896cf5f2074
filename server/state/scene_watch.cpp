// SPDX-License-Identifier: Apache-2.0
#include "server/state/scene_watch.hpp"

#include <utility>

namespace fanlight {

namespace {

// More changes than a client may make in kWithdrawalNs are joined to the newest one.
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
  // Time without pictures does not count.
  if (!now.are_pictures_expected)
    for (Change& each : waiting_) each.since_ns += gap_ns;
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
