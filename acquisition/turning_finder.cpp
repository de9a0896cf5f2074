#include "acquisition/turning_finder.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace fanlight {

namespace {

constexpr double kReturnSteps = 1.2;
constexpr double kLeastShare = 0.01;  // of the range
constexpr double kMostShare = 0.25;

}  // namespace

TurningFinder::TurningFinder(const Range& range)
    : range_rad_(std::abs(range.last_angle_rad - range.first_angle_rad)) {}

bool TurningFinder::turned(std::uint64_t sequence, double angle_rad) {
  const Look look{sequence, angle_rad};
  if (!std::exchange(begun_, true)) start_ = lowest_ = highest_ = look;
  if (angle_rad < lowest_.angle_rad) lowest_ = look;
  if (angle_rad > highest_.angle_rad) highest_ = look;
  if (way_ == 0) {
    find_way();
    return false;
  }
  const Look extreme = way_ > 0 ? highest_ : lowest_;
  const double least_rad = least_return_rad();
  if (way_ * (extreme.angle_rad - angle_rad) < least_rad) return false;
  const double covered_rad = way_ * (extreme.angle_rad - start_.angle_rad);
  if (covered_rad < 2 * least_rad) return false;

  step_rad_ = covered_rad / static_cast<double>(extreme.sequence - start_.sequence);
  way_ = -way_;
  extreme_sequence_ = extreme.sequence;
  start_ = lowest_ = highest_ = extreme;
  (way_ > 0 ? highest_ : lowest_) = look;
  return true;
}

void TurningFinder::begin_anew() {
  way_ = 0;
  begun_ = false;
}

double TurningFinder::least_return_rad() const {
  return std::clamp(kReturnSteps * step_rad_, kLeastShare * range_rad_, kMostShare * range_rad_);
}

void TurningFinder::find_way() {
  // Twice what passes for jitter; the outermost angle that came last tells where it goes.
  if (highest_.angle_rad - lowest_.angle_rad < 2 * least_return_rad()) return;
  way_ = highest_.sequence > lowest_.sequence ? 1 : -1;
  start_ = way_ > 0 ? lowest_ : highest_;
}

}  // namespace fanlight
