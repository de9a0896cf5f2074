// SPDX-License-Identifier: Apache-2.0
#include "acquisition/igtl/pose_history.hpp"

#include <algorithm>
#include <cstdlib>

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

PoseHistory::PoseHistory() {
  for (History& history : histories_) history.poses.resize(kMostPoses);
}

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
  // A clock that goes back ends what was known.
  if (history.count > 0 && time_ns < newest(history, 0).time_ns) history.count = 0;
  history.poses[history.count++ % kMostPoses] = {time_ns, pose};
}

PoseHistory::Answer PoseHistory::at(std::size_t device, std::int64_t time_ns) const {
  const History& history = histories_[device];
  const std::size_t kept = std::min(history.count, kMostPoses);
  const Timed* after = nullptr;
  for (std::size_t back = 0; back < kept; ++back) {
    const Timed& each = newest(history, back);
    if (std::abs(each.time_ns - time_ns) <= kSameNs) return {each.pose, false};
    if (each.time_ns > time_ns) {
      after = &each;
      continue;
    }
    const bool near = time_ns - each.time_ns <= kMostApartNs;
    if (after == nullptr) return {near ? std::optional(each.pose) : std::nullopt, true};
    const bool both_near = near && after->time_ns - time_ns <= kMostApartNs;
    if (!both_near) {
      if (near) return {each.pose, false};
      break;
    }
    const double share =
        static_cast<double>(time_ns - each.time_ns) / static_cast<double>(after->time_ns - each.time_ns);
    return {between(each.pose, after->pose, share), false};
  }
  if (after == nullptr) return {std::nullopt, true};
  const bool near = after->time_ns - time_ns <= kMostApartNs;
  return {near ? std::optional(after->pose) : std::nullopt, false};
}

}  // namespace fanlight
