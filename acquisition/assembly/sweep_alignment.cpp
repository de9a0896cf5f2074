// SPDX-License-Identifier: Apache-2.0
#include "acquisition/assembly/sweep_alignment.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace fanlight {

namespace {

using Blocks = SweepThumbnails::Blocks;

constexpr double kReachRad = radians(4.0);
constexpr double kTrialStepRad = radians(0.5);
constexpr double kConvergedRad = radians(0.001);
constexpr int kMostSteps = 12;
// A larger standard error means that the frames hardly change with the angle, or that the sweeps show
// different things.
constexpr double kLargestErrorRad = radians(0.25);

/// Position in a sweep between two of its frames.
struct InterpolatedFrame {
  const Blocks* low = nullptr;
  const Blocks* high = nullptr;
  float upper_weight = 0;  // weight of the upper frame
  double step_rad = 0;
  double time_s = 0;
};

/// Steps along a sweep. The requested angles must ascend.
class SweepCursor {
 public:
  explicit SweepCursor(const SweepThumbnails& sweep) : sweep_(sweep) {}

  /// nullopt before the first and beyond the last frame.
  std::optional<InterpolatedFrame> at(double angle_rad) {
    const std::uint32_t last = sweep_.frames() - 1;
    if (angle_rad < sweep_.angle_rad(0) || angle_rad > sweep_.angle_rad(last)) return std::nullopt;
    // Frames at equal angles are skipped; a step of width 0 is possible at the end only.
    while (below_ + 1 < last && sweep_.angle_rad(below_ + 1) <= angle_rad) ++below_;
    const double step_rad = sweep_.angle_rad(below_ + 1) - sweep_.angle_rad(below_);
    if (step_rad <= 0) return std::nullopt;
    const double upper_weight = (angle_rad - sweep_.angle_rad(below_)) / step_rad;
    return InterpolatedFrame{&sweep_.blocks(below_), &sweep_.blocks(below_ + 1),
                             static_cast<float>(upper_weight), step_rad,
                             std::lerp(sweep_.time_s(below_), sweep_.time_s(below_ + 1), upper_weight)};
  }

 private:
  const SweepThumbnails& sweep_;
  std::uint32_t below_ = 0;
};

/// Sums over all blocks of the compared frames.
struct Sums {
  double frames = 0;
  double differences_squared = 0;
  double slopes_and_differences = 0;
  double slopes_squared = 0;
  double slopes_of_both = 0;  // product of the slopes of the middle sweep and of its neighbours

  void add(const SweepThumbnails& middle, std::uint32_t frame, const InterpolatedFrame& before,
           const InterpolatedFrame& after) {
    const Blocks& lower = middle.blocks(frame - 1);
    const Blocks& here = middle.blocks(frame);
    const Blocks& upper = middle.blocks(frame + 1);
    const auto per_rad = static_cast<float>(1 / (middle.angle_rad(frame + 1) - middle.angle_rad(frame - 1)));
    const double apart_s = after.time_s - before.time_s;
    const double since_s = middle.time_s(frame) - before.time_s;
    const auto later = static_cast<float>(apart_s > 0 ? std::clamp(since_s / apart_s, 0.0, 1.0) : 0.5);
    const auto before_per_rad = static_cast<float>(1 / before.step_rad);
    const auto after_per_rad = static_cast<float>(1 / after.step_rad);
    float squares = 0;
    float with_difference = 0;
    float with_itself = 0;
    float with_other = 0;
    for (std::size_t i = 0; i < here.size(); ++i) {
      const float before_step = (*before.high)[i] - (*before.low)[i];
      const float after_step = (*after.high)[i] - (*after.low)[i];
      const float earlier_grey = (*before.low)[i] + before.upper_weight * before_step;
      const float later_grey = (*after.low)[i] + after.upper_weight * after_step;
      const float difference = earlier_grey + later * (later_grey - earlier_grey) - here[i];
      // Slope of the sweep that is not interpolated, without the frame that is compared. Otherwise the same
      // speckle would be in both factors, and would pull the shift towards the angles where interpolation
      // smooths most.
      const float slope = (upper[i] - lower[i]) * per_rad;
      const float early_slope = before_step * before_per_rad;
      const float other_slope = early_slope + later * (after_step * after_per_rad - early_slope);
      squares += difference * difference;
      with_difference += slope * difference;
      with_itself += slope * slope;
      with_other += slope * other_slope;
    }
    ++frames;
    differences_squared += double{squares};
    slopes_and_differences += double{with_difference};
    slopes_squared += double{with_itself};
    slopes_of_both += double{with_other};
  }

  /// Gauss-Newton. The speckle in the two slopes is independent, so it cancels in their product.
  double step_rad() const { return -slopes_and_differences / slopes_of_both; }

  double error_rad() const {
    const double variance = differences_squared / (frames * Blocks{}.size());
    return std::sqrt(variance * slopes_squared) / slopes_of_both;
  }
};

struct SweepTriple {
  const SweepThumbnails& before;
  const SweepThumbnails& middle;
  const SweepThumbnails& after;

  Sums sums_at(double shift_rad) const {
    SweepCursor before_cursor(before);
    SweepCursor after_cursor(after);
    Sums sums;
    for (std::uint32_t frame = 1; frame + 1 < middle.frames(); ++frame) {
      if (middle.angle_rad(frame + 1) <= middle.angle_rad(frame - 1)) continue;
      const auto earlier = before_cursor.at(middle.angle_rad(frame) + shift_rad);
      const auto later = after_cursor.at(middle.angle_rad(frame) + shift_rad);
      if (earlier && later) sums.add(middle, frame, *earlier, *later);
    }
    return sums;
  }
  bool has_enough_frames(const Sums& sums) const { return sums.frames >= 0.5 * middle.frames(); }
};

std::optional<double> best_trial_rad(const SweepTriple& triple) {
  std::optional<double> best_rad;
  double least = std::numeric_limits<double>::infinity();
  const int trials = static_cast<int>(kReachRad / kTrialStepRad);
  for (int trial = -trials; trial <= trials; ++trial) {
    const Sums sums = triple.sums_at(trial * kTrialStepRad);
    if (!triple.has_enough_frames(sums) || sums.differences_squared / sums.frames >= least) continue;
    least = sums.differences_squared / sums.frames;
    best_rad = trial * kTrialStepRad;
  }
  return best_rad;
}

}  // namespace

std::optional<double> shift_between(const SweepThumbnails& before, const SweepThumbnails& middle,
                                    const SweepThumbnails& after) {
  if (std::min({before.frames(), middle.frames(), after.frames()}) < 3) return std::nullopt;
  if (before.geometry() != middle.geometry() || after.geometry() != middle.geometry()) return std::nullopt;
  const SweepTriple triple{before, middle, after};
  std::optional<double> shift_rad = best_trial_rad(triple);
  if (!shift_rad) return std::nullopt;
  for (int step = 0; step < kMostSteps; ++step) {
    const Sums sums = triple.sums_at(*shift_rad);
    // False for a NaN, which frames without any difference give.
    const bool sure = sums.error_rad() > 0 && sums.error_rad() <= kLargestErrorRad;
    const bool alike = sums.differences_squared == 0 && sums.slopes_of_both > 0;
    if (!triple.has_enough_frames(sums) || !(sure || alike)) return std::nullopt;
    *shift_rad += sums.step_rad();
    if (std::abs(*shift_rad) > kReachRad) return std::nullopt;
    if (std::abs(sums.step_rad()) < kConvergedRad) return shift_rad;
  }
  return std::nullopt;
}

}  // namespace fanlight
