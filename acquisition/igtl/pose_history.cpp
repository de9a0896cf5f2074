// SPDX-License-Identifier: Apache-2.0
#include "acquisition/igtl/pose_history.hpp"

#include <algorithm>

namespace fanlight {

namespace {

// PLUS gives an image and its transforms one time; it may be rounded on the way.
constexpr std::int64_t kSameNs = 500'000;

igtl::GridPose between(const igtl::GridPose& from, const igtl::GridPose& to, double share) {
  const auto mix = [share](const std::array<double, 3>& a, const std::array<double, 3>& b) {
    return std::array<double, 3>{a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]),
                                 a[2] + share * (b[2] - a[2])};
  };
  return {mix(from.i_mm, to.i_mm), mix(from.j_mm, to.j_mm), mix(from.k_mm, to.k_mm),
          mix(from.first_mm, to.first_mm)};
}

}  // namespace

void PoseHistory::clear() {
  for (History& history : histories_) history.count = 0;
}

std::optional<std::size_t> PoseHistory::find(std::string_view name) const {
  for (std::size_t device = 0; device < devices_; ++device)
    if (histories_[device].name.view() == name) return device;
  return std::nullopt;
}

void PoseHistory::add(const igtl::DeviceName& device, std::int64_t time_ns, const igtl::GridPose& pose) {
  const auto known = find(device.view());
  if (!known && devices_ == kMostDevices) return;
  History& history = histories_[known ? *known : devices_++];
  history.name = device;
  history.poses.resize(kMostPoses);
  // A clock that goes back ends what was known.
  if (history.count > 0 && time_ns < newest(history, 0).time_ns) history.count = 0;
  history.poses[history.count++ % kMostPoses] = {time_ns, pose};
}

/// How many of the newest poses are later than the time. They rise in time.
std::size_t PoseHistory::later_than(const History& history, std::int64_t time_ns) const {
  std::size_t low = 0;
  std::size_t high = std::min(history.count, kMostPoses);
  while (low < high) {
    const std::size_t middle = (low + high) / 2;
    if (newest(history, middle).time_ns > time_ns) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  return low;
}

PoseHistory::Answer PoseHistory::at(std::size_t device, std::int64_t time_ns) const {
  const History& history = histories_[device];
  const std::size_t kept = std::min(history.count, kMostPoses);
  const std::size_t later = later_than(history, time_ns);
  const Timed* const after = later > 0 ? &newest(history, later - 1) : nullptr;
  const Timed* const before = later < kept ? &newest(history, later) : nullptr;
  const std::int64_t since_ns = before != nullptr ? time_ns - before->time_ns : kMostApartNs + 1;
  const std::int64_t until_ns = after != nullptr ? after->time_ns - time_ns : kMostApartNs + 1;
  const bool may_come = after == nullptr && since_ns > kSameNs;
  if (since_ns <= kSameNs) return {before->pose, false};
  if (until_ns <= kSameNs) return {after->pose, false};
  if (since_ns <= kMostApartNs && until_ns <= kMostApartNs) {
    const double share = static_cast<double>(since_ns) / static_cast<double>(since_ns + until_ns);
    return {between(before->pose, after->pose, share), false};
  }
  if (since_ns <= kMostApartNs) return {before->pose, may_come};
  if (until_ns <= kMostApartNs) return {after->pose, false};
  return {std::nullopt, may_come};
}

}  // namespace fanlight
