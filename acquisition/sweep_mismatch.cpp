#include "acquisition/sweep_mismatch.hpp"

#include <algorithm>
#include <cmath>

#include "acquisition/sweep_alignment.hpp"

namespace fanlight {

namespace {

// Fewer couples of estimates agree by chance.
constexpr std::size_t kFewestCouples = 3;
// Few, so that what is reported is news; enough, so that motion is not reported as a mismatch.
constexpr std::size_t kReported = 4;

// A smaller change is not worth a new table of angles in the renderer with every volume.
constexpr double kLeastChangeRad = radians(0.02);

}  // namespace

SweepMismatch::SweepMismatch(std::uint32_t frame_capacity, AcquisitionCounters& counters)
    : counters_(counters),
      sweeps_{Sweep{SweepThumbnails(frame_capacity)}, Sweep{SweepThumbnails(frame_capacity)},
              Sweep{SweepThumbnails(frame_capacity)}} {}

void SweepMismatch::correct(Volume& volume, std::span<const FrameStamp> frames) {
  const SweepDirection direction = volume.stamp().direction;
  if (direction_ == direction) {
    sweeps_in_a_row_ = 0;
    estimates_in_a_row_ = 0;
  } else {
    std::rotate(sweeps_.begin(), sweeps_.end() - 1, sweeps_.end());
    sweeps_[0].thumbnails.take(volume, frames);
    sweeps_in_a_row_ = std::min(sweeps_in_a_row_ + 1, kCompared);
    if (sweeps_in_a_row_ == kCompared) compare(direction, volume.geometry());
    sweeps_[0].corrected_rad = mismatch_rad_;
  }
  direction_ = direction;
  volume.turn_by(direction == SweepDirection::kForward ? mismatch_rad_ / 2 : -mismatch_rad_ / 2);
}

void SweepMismatch::forget_volumes() {
  direction_.reset();
  sweeps_in_a_row_ = 0;
  estimates_in_a_row_ = 0;
}

void SweepMismatch::compare(SweepDirection newest, const FanGeometry& geometry) {
  const auto shift_rad = shift_between(sweeps_[2].thumbnails, sweeps_[1].thumbnails, sweeps_[0].thumbnails);
  if (!shift_rad) {
    counters_.mismatch_refusals.add();
    estimates_in_a_row_ = 0;
    return;
  }
  counters_.mismatch_estimates.add();
  std::shift_right(estimates_.begin(), estimates_.end(), 1);
  // The shift is that of the sweep in the middle, which went the other way than the newest.
  Estimate& estimate = estimates_[0];
  estimate.mismatch_rad = newest == SweepDirection::kBackward ? *shift_rad : -*shift_rad;
  estimates_in_a_row_ = std::min(estimates_in_a_row_ + 1, kMostEstimates);
  if (estimates_in_a_row_ > 1) {
    std::shift_right(couples_rad_.begin(), couples_rad_.end(), 1);
    couples_rad_[0] = (estimates_[0].mismatch_rad + estimates_[1].mismatch_rad) / 2;
    couples_ = std::min(couples_ + 1, kMostCouples);
  }
  if (couples_ >= kFewestCouples) {
    const double believed = believed_rad();
    if (std::abs(believed - mismatch_rad_) >= kLeastChangeRad) mismatch_rad_ = believed;
  }
  const double corrected_rad =
      (sweeps_[1].corrected_rad + (sweeps_[2].corrected_rad + mismatch_rad_) / 2) / 2;
  estimate.left_rad = estimate.mismatch_rad - corrected_rad;
  report(geometry);
}

double SweepMismatch::believed_rad() const {
  std::array<double, kMostCouples> sorted = couples_rad_;
  const auto used = std::span(sorted).first(couples_);
  const auto median = [&used] {
    std::ranges::sort(used);
    return (used[used.size() / 2] + used[(used.size() - 1) / 2]) / 2;
  };
  const double middle_rad = median();
  for (double& couple : used) couple = std::abs(couple - middle_rad);
  // 1.4826 makes the median deviation of a normal distribution its standard one; couples overlap by half.
  const double error_rad = 1.4826 * median() / std::sqrt(std::max(1.0, static_cast<double>(couples_) / 2));
  const double doubt = 2 * error_rad / std::max(std::abs(middle_rad), 1e-9);
  return middle_rad * std::max(0.0, 1 - doubt * doubt);
}

double SweepMismatch::weighted(double Estimate::*value, std::size_t newest) const {
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

void SweepMismatch::report(const FanGeometry& geometry) {
  const double left_rad = weighted(&Estimate::left_rad, std::min(estimates_in_a_row_, kReported));
  const double radius_mm = geometry.motor_radius_mm + geometry.depth_mm() / 2;
  counters_.mismatch_deg.set(degrees(mismatch_rad_));
  counters_.mismatch_left_deg.set(degrees(left_rad));
  counters_.mismatch_left_mm.set(radius_mm * left_rad);
}

}  // namespace fanlight
