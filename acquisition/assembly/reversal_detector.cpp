// SPDX-License-Identifier: Apache-2.0
#include "acquisition/assembly/reversal_detector.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace fanlight {

namespace {

constexpr double kReturnSteps = 1.2;
constexpr double kLeastShare = 0.01;  // of the motor's range
constexpr double kMostShare = 0.25;

}  // namespace

ReversalDetector::ReversalDetector(const Range& range)
    : range_rad_(std::abs(range.last_angle_rad - range.first_angle_rad)) {}

bool ReversalDetector::reversed(std::uint64_t sequence, double angle_rad) {
  const Sample sample{sequence, angle_rad};
  if (!std::exchange(started_, true)) start_ = lowest_ = highest_ = sample;
  if (angle_rad < lowest_.angle_rad) lowest_ = sample;
  if (angle_rad > highest_.angle_rad) highest_ = sample;
  if (direction_sign_ == 0) {
    find_direction();
    return false;
  }
  const Sample extreme = direction_sign_ > 0 ? highest_ : lowest_;
  const double least_rad = least_return_rad();
  if (direction_sign_ * (extreme.angle_rad - angle_rad) < least_rad) return false;
  const double covered_rad = direction_sign_ * (extreme.angle_rad - start_.angle_rad);
  if (covered_rad < 2 * least_rad) return false;

  step_rad_ = covered_rad / static_cast<double>(extreme.sequence - start_.sequence);
  direction_sign_ = -direction_sign_;
  extreme_sequence_ = extreme.sequence;
  start_ = lowest_ = highest_ = extreme;
  (direction_sign_ > 0 ? highest_ : lowest_) = sample;
  return true;
}

void ReversalDetector::reset() {
  direction_sign_ = 0;
  started_ = false;
}

double ReversalDetector::least_return_rad() const {
  return std::clamp(kReturnSteps * step_rad_, kLeastShare * range_rad_, kMostShare * range_rad_);
}

void ReversalDetector::find_direction() {
  // Twice the tolerated jitter. The extreme that was reached last gives the direction.
  if (highest_.angle_rad - lowest_.angle_rad < 2 * least_return_rad()) return;
  direction_sign_ = highest_.sequence > lowest_.sequence ? 1 : -1;
  start_ = direction_sign_ > 0 ? lowest_ : highest_;
}

}  // namespace fanlight
