// SPDX-License-Identifier: Apache-2.0
#include "acquisition/source/angle_check.hpp"

#include <algorithm>
#include <cmath>
#include <span>

namespace fanlight {

namespace {

// A step above this multiple of the median is none of the motor's.
constexpr double kBeyondMedian = 6;
// A step below this share of the mean is none.
constexpr double kStill = 0.25;

}  // namespace

AngleCheck::AngleCheck(std::size_t frame_capacity) {
  steps_rad_.reserve(frame_capacity);
  runs_.reserve(frame_capacity);
  outliers_.reserve(frame_capacity);
}

bool AngleCheck::jumps(const Frame& from, const Frame& to) const {
  const auto passed = static_cast<double>(to.sequence - from.sequence);
  return std::abs(to.angle_rad - from.angle_rad) > kMostSteps * usual_rad_ * passed;
}

double AngleCheck::usual_step_rad(std::span<const Frame> frames) {
  steps_rad_.clear();
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const auto passed = static_cast<double>(frames[i].sequence - frames[i - 1].sequence);
    steps_rad_.push_back(std::abs(frames[i].angle_rad - frames[i - 1].angle_rad) / passed);
  }
  std::ranges::sort(steps_rad_);
  const auto [smallest, largest] = std::ranges::minmax(frames, {}, &Frame::angle_rad);
  const double still_rad =
      kStill * (largest.angle_rad - smallest.angle_rad) / static_cast<double>(frames.size());
  const std::span<const double> moving(std::ranges::upper_bound(steps_rad_, still_rad), steps_rad_.end());
  if (moving.empty()) return 0;
  const double median = moving[(moving.size() - 1) / 2];
  double sum = 0;
  std::size_t counted = 0;
  for (const double step : moving) {
    if (step > kBeyondMedian * median) break;
    sum += step;
    ++counted;
  }
  return std::max(median, sum / static_cast<double>(counted));
}

/// Fills runs_: frames without a jump between them.
void AngleCheck::cut_at_jumps(std::span<const Frame> frames) {
  runs_.clear();
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (i == 0 || jumps(frames[i - 1], frames[i])) runs_.push_back({.first = i});
    runs_.back().end = i + 1;
  }
}

std::size_t AngleCheck::longest_run() const {
  const auto longest =
      std::ranges::max_element(runs_, {}, [](const Run& run) { return run.end - run.first; });
  return static_cast<std::size_t>(longest - runs_.begin());
}

AngleCheck::Findings AngleCheck::check(std::span<const Frame> frames) {
  outliers_.clear();
  usual_rad_ = 0;
  if (frames.size() < kFewestFrames) return {};
  usual_rad_ = usual_step_rad(frames);
  if (usual_rad_ == 0) return {};
  cut_at_jumps(frames);

  // From the longest run in both directions: a run that agrees with the one kept last is kept. A short one
  // that does not is an outlier, a long one is a part of the sweep behind a gap.
  const std::size_t anchor = longest_run();
  runs_[anchor].kept = true;
  double gap_rad = 0;
  const auto judge = [&](Run& run, const Run& last_kept) {
    const bool after = run.first > last_kept.first;
    const Frame& from = after ? frames[last_kept.end - 1] : frames[run.end - 1];
    const Frame& to = after ? frames[run.first] : frames[last_kept.first];
    const bool agrees = !jumps(from, to);
    run.kept = agrees || run.end - run.first > kMostOutliersInARow;
    const double step_rad = std::abs(to.angle_rad - from.angle_rad);
    const bool is_gap = step_rad > kGapSteps * usual_rad_ * static_cast<double>(to.sequence - from.sequence);
    if (run.kept && is_gap) gap_rad = std::max(gap_rad, step_rad);
    return run.kept;
  };
  std::size_t last = anchor;
  for (std::size_t i = anchor + 1; i < runs_.size(); ++i) {
    if (judge(runs_[i], runs_[last])) last = i;
  }
  last = anchor;
  for (std::size_t i = anchor; i-- > 0;) {
    if (judge(runs_[i], runs_[last])) last = i;
  }
  for (const Run& run : runs_) {
    for (std::size_t i = run.first; i < run.end && !run.kept; ++i) outliers_.push_back(i);
  }
  return {.outliers = outliers_, .usual_step_rad = usual_rad_, .gap_rad = gap_rad};
}

}  // namespace fanlight
