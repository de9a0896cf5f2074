// SPDX-License-Identifier: Apache-2.0
#include "acquisition/assembly/sweep_hysteresis.hpp"

#include <algorithm>
#include <cmath>

#include "acquisition/assembly/sweep_alignment.hpp"

namespace fanlight {

namespace {

// Fewer pairs may agree by chance.
constexpr std::size_t kFewestPairs = 3;
// Small enough for recent values, large enough that motion is not reported as a mismatch.
constexpr std::size_t kReported = 4;

// A smaller change is not worth a new angle table in the renderer with every volume.
constexpr double kLeastChangeRad = radians(0.02);

}  // namespace

SweepHysteresis::SweepHysteresis(std::uint32_t frame_capacity, AcquisitionCounters& counters)
    : counters_(counters),
      sweeps_{Sweep{SweepThumbnails(frame_capacity)}, Sweep{SweepThumbnails(frame_capacity)},
              Sweep{SweepThumbnails(frame_capacity)}} {}

void SweepHysteresis::correct(Volume& volume, const SweepThumbnails& thumbnails) {
  const SweepDirection direction = volume.stamp().direction;
  if (direction_ == direction) {
    alternating_sweeps_ = 0;
    successive_estimates_ = 0;
  } else {
    std::rotate(sweeps_.begin(), sweeps_.end() - 1, sweeps_.end());
    sweeps_[0].thumbnails = thumbnails;  // of the same capacity: does not allocate
    alternating_sweeps_ = std::min(alternating_sweeps_ + 1, kCompared);
    if (alternating_sweeps_ == kCompared) compare(direction, volume.geometry());
    sweeps_[0].corrected_rad = mismatch_rad_;
  }
  direction_ = direction;
  volume.turn_by(direction == SweepDirection::kForward ? mismatch_rad_ / 2 : -mismatch_rad_ / 2);
}

void SweepHysteresis::forget_volumes() {
  direction_.reset();
  alternating_sweeps_ = 0;
  successive_estimates_ = 0;
}

void SweepHysteresis::compare(SweepDirection newest, const FanGeometry& geometry) {
  const auto shift_rad = shift_between(sweeps_[2].thumbnails, sweeps_[1].thumbnails, sweeps_[0].thumbnails);
  if (!shift_rad) {
    counters_.mismatch_refusals.add();
    successive_estimates_ = 0;
    return;
  }
  counters_.mismatch_estimates.add();
  std::shift_right(estimates_.begin(), estimates_.end(), 1);
  // The shift belongs to the sweep in the middle, whose direction is opposite to the newest.
  Estimate& estimate = estimates_[0];
  estimate.mismatch_rad = newest == SweepDirection::kBackward ? *shift_rad : -*shift_rad;
  successive_estimates_ = std::min(successive_estimates_ + 1, kMostEstimates);
  if (successive_estimates_ > 1) {
    std::shift_right(pairs_rad_.begin(), pairs_rad_.end(), 1);
    pairs_rad_[0] = (estimates_[0].mismatch_rad + estimates_[1].mismatch_rad) / 2;
    pairs_ = std::min(pairs_ + 1, kMostPairs);
  }
  if (pairs_ >= kFewestPairs) {
    const double estimated = estimated_rad();
    if (std::abs(estimated - mismatch_rad_) >= kLeastChangeRad) mismatch_rad_ = estimated;
  }
  const double corrected_rad =
      (sweeps_[1].corrected_rad + (sweeps_[2].corrected_rad + mismatch_rad_) / 2) / 2;
  estimate.remaining_rad = estimate.mismatch_rad - corrected_rad;
  report(geometry);
}

double SweepHysteresis::estimated_rad() const {
  std::array<double, kMostPairs> sorted = pairs_rad_;
  const auto used = std::span(sorted).first(pairs_);
  const auto median = [&used] {
    std::ranges::sort(used);
    return (used[used.size() / 2] + used[(used.size() - 1) / 2]) / 2;
  };
  const double middle_rad = median();
  for (double& pair : used) pair = std::abs(pair - middle_rad);
  // 1.4826 converts the median deviation of a normal distribution to its standard deviation; pairs overlap by
  // half.
  const double error_rad = 1.4826 * median() / std::sqrt(std::max(1.0, static_cast<double>(pairs_) / 2));
  const double doubt = 2 * error_rad / std::max(std::abs(middle_rad), 1e-9);
  return middle_rad * std::max(0.0, 1 - doubt * doubt);
}

double SweepHysteresis::weighted(double Estimate::*value, std::size_t newest) const {
  double weight = 1;
  double weights = 0;
  double sum = 0;
  for (std::size_t i = 0; i < newest; ++i) {
    sum += weight * estimates_[i].*value;
    weights += weight;
    weight *= static_cast<double>(newest - 1 - i) / static_cast<double>(i + 1);
  }
  return sum / weights;
}

void SweepHysteresis::report(const FanGeometry& geometry) {
  // A single estimate holds all of the scene's motion, which is of opposite sign in the next one.
  if (successive_estimates_ < kReported) return;
  const double remaining_rad = weighted(&Estimate::remaining_rad, kReported);
  const double radius_mm = geometry.motor_radius_mm + geometry.depth_mm() / 2;
  counters_.mismatch_deg.set(degrees(mismatch_rad_));
  counters_.mismatch_left_deg.set(degrees(remaining_rad));
  counters_.mismatch_left_m.set(radius_mm * remaining_rad / 1000);
}

}  // namespace fanlight
