#include "renderer/angle_table.hpp"

#include <algorithm>
#include <cmath>

namespace fanlight {

namespace {

// Where frames are uneven, the kink between them is rounded off within an entry: at 200 mm from the axis and
// 90 deg of sweep an entry is 0.08 mm wide.
constexpr std::size_t kEntries = 4096;
// Beyond the first and last frame, so that samples just outside interpolate too.
constexpr double kMarginEntries = 2;

}  // namespace

AngleTable::AngleTable(double first_angle_rad, double last_angle_rad, std::uint32_t frame_capacity)
    : expected_first_rad_(first_angle_rad),
      expected_last_rad_(last_angle_rad),
      angles_(kEntries),
      entries_(kEntries),
      placed_angles_(frame_capacity) {}

void AngleTable::span(double first_angle_rad, double last_angle_rad) {
  if (first_rad_ == first_angle_rad && last_rad_ == last_angle_rad) return;
  first_rad_ = first_angle_rad;
  last_rad_ = last_angle_rad;
  const double first = std::tan(first_rad_ / 2);
  const double last = std::tan(last_rad_ / 2);
  scale_ = (kEntries - 1 - 2 * kMarginEntries) / (last - first);
  offset_ = kMarginEntries - first * scale_;
  for (std::size_t entry = 0; entry < kEntries; ++entry) {
    angles_[entry] = 2 * std::atan((static_cast<double>(entry) - offset_) / scale_);
  }
}

bool AngleTable::place(std::span<const double> angles_rad) {
  const bool changed = placed_frames_ != angles_rad.size() ||
                       !std::ranges::equal(angles_rad, std::span(placed_angles_).first(placed_frames_));
  std::ranges::copy(angles_rad, placed_angles_.begin());
  placed_frames_ = static_cast<std::uint32_t>(angles_rad.size());
  if (!changed) return false;

  const std::size_t last = angles_rad.size() - 1;
  span(std::min(expected_first_rad_, angles_rad.front()), std::max(expected_last_rad_, angles_rad.back()));
  const double mean_step_rad = (angles_rad.back() - angles_rad.front()) / static_cast<double>(last);
  // Angles only grow along the table, so the frame below an entry is found by walking on.
  std::size_t below = 0;
  for (std::size_t entry = 0; entry < kEntries; ++entry) {
    const double at_rad = angles_[entry];
    while (below < last && placed_angles_[below + 1] <= at_rad) ++below;
    double coordinate = 0;
    if (at_rad < placed_angles_[0]) {
      coordinate = (at_rad - placed_angles_[0]) / mean_step_rad;
    } else if (below == last) {
      coordinate = static_cast<double>(last) + (at_rad - placed_angles_[last]) / mean_step_rad;
    } else {
      // Frames at one angle are passed over by the walk, so this step is never 0 wide.
      const double step_rad = placed_angles_[below + 1] - placed_angles_[below];
      coordinate = static_cast<double>(below) + (at_rad - placed_angles_[below]) / step_rad;
    }
    entries_[entry] = static_cast<float>(coordinate);
  }
  return true;
}

}  // namespace fanlight
