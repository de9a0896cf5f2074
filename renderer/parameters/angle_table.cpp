// SPDX-License-Identifier: Apache-2.0
#include "renderer/parameters/angle_table.hpp"

#include <algorithm>
#include <cmath>

namespace fanlight {

namespace {

// At frames with uneven spacing the coordinate has a kink, which is smoothed within one entry: 0.08 mm at 200
// mm from the axis and 90 deg of sweep.
constexpr std::size_t kEntries = 4096;
// Entries beyond the first and last frame, so that samples just outside can interpolate.
constexpr double kMarginEntries = 2;

}  // namespace

AngleTable::AngleTable(double first_angle_rad, double last_angle_rad, std::uint32_t frame_capacity)
    : expected_first_rad_(first_angle_rad),
      expected_last_rad_(last_angle_rad),
      entry_angles_rad_(kEntries),
      entries_(kEntries),
      frame_angles_rad_(frame_capacity) {}

void AngleTable::set_span(double first_angle_rad, double last_angle_rad) {
  if (first_rad_ == first_angle_rad && last_rad_ == last_angle_rad) return;
  first_rad_ = first_angle_rad;
  last_rad_ = last_angle_rad;
  const double first = std::tan(first_rad_ / 2);
  const double last = std::tan(last_rad_ / 2);
  scale_ = (kEntries - 1 - 2 * kMarginEntries) / (last - first);
  offset_ = kMarginEntries - first * scale_;
  for (std::size_t entry = 0; entry < kEntries; ++entry) {
    entry_angles_rad_[entry] = 2 * std::atan((static_cast<double>(entry) - offset_) / scale_);
  }
}

bool AngleTable::update(std::span<const double> angles_rad) {
  const bool changed = frames_ != angles_rad.size() ||
                       !std::ranges::equal(angles_rad, std::span(frame_angles_rad_).first(frames_));
  std::ranges::copy(angles_rad, frame_angles_rad_.begin());
  frames_ = static_cast<std::uint32_t>(angles_rad.size());
  if (!changed) return false;

  const std::size_t last = angles_rad.size() - 1;
  set_span(std::min(expected_first_rad_, angles_rad.front()),
           std::max(expected_last_rad_, angles_rad.back()));
  const double mean_step_rad = (angles_rad.back() - angles_rad.front()) / static_cast<double>(last);
  // Angles ascend along the table, so the search for the frame below an entry continues from the last one.
  std::size_t below = 0;
  for (std::size_t entry = 0; entry < kEntries; ++entry) {
    const double at_rad = entry_angles_rad_[entry];
    while (below < last && frame_angles_rad_[below + 1] <= at_rad) ++below;
    double coordinate = 0;
    if (at_rad < frame_angles_rad_[0]) {
      coordinate = (at_rad - frame_angles_rad_[0]) / mean_step_rad;
    } else if (below == last) {
      coordinate = static_cast<double>(last) + (at_rad - frame_angles_rad_[last]) / mean_step_rad;
    } else {
      // The search skips frames at equal angles, so this step is never 0.
      const double step_rad = frame_angles_rad_[below + 1] - frame_angles_rad_[below];
      coordinate = static_cast<double>(below) + (at_rad - frame_angles_rad_[below]) / step_rad;
    }
    entries_[entry] = static_cast<float>(coordinate);
  }
  return true;
}

}  // namespace fanlight
