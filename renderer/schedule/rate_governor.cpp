// SPDX-License-Identifier: Apache-2.0
#include "renderer/schedule/rate_governor.hpp"

#include <algorithm>
#include <numeric>

namespace fanlight {

namespace {

// Of the wanted period.
constexpr double kLate = 1.1;
constexpr double kFits = 0.8;
// No reduction gains more; a picture that seems to was cheap for another reason.
constexpr double kMostGain = 4;
// A level that is entered again within this time was left too early.
constexpr std::int64_t kRegretNs = 10'000'000'000;
constexpr std::int64_t kLongestStayNs = 60'000'000'000;

double period_ms(const Scene& scene) {
  return 1000 / scene.deadline.rate_hz;
}

/// What a picture takes of the time from one volume to the next. Where the passes of two volumes overlap, the
/// longer part: its time holds what the other part takes of the processors.
double work_ms(const PictureStamp& stamp) {
  const auto filter = stamp.stage_ms.begin() + static_cast<std::ptrdiff_t>(Stage::kFilter);
  const double cast_ms = std::accumulate(stamp.stage_ms.begin(), filter, 0.0);
  const double light_ms = std::accumulate(filter, stamp.stage_ms.end(), 0.0);
  return stamp.passes_overlap ? std::max(cast_ms, light_ms) : cast_ms + light_ms;
}

}  // namespace

void RateGovernor::scene_came(const Scene& scene, std::int64_t now_ns) {
  const DeadlinePlan plan = scene.deadline.plan;
  if (plan == DeadlinePlan::kOff || plan != scene_.deadline.plan) {
    *this = RateGovernor();
    level_ = plan == DeadlinePlan::kSmoothWhileMoving ? 1 : 0;
  } else if (has_scene_ && first_pass_changed(scene_, scene) <= FirstPass::kCast) {
    last_moved_ns_ = now_ns;
  }
  scene_ = scene;
  has_scene_ = true;
}

RateGovernor::Reduction RateGovernor::reduction_of(const PictureStamp& stamp) {
  const DeadlineMeasures& measures = stamp.measures;
  if (measures.cheap_filters) return kFilters;
  if (measures.wide_step) return kSteps;
  return measures.coarse ? kRays : kNothing;
}

bool RateGovernor::still(std::int64_t now_ns) const {
  return now_ns >= std::max(last_volume_ns_, last_moved_ns_) + kStillNs;
}

RateGovernor::Reduction RateGovernor::reduction_at(std::int64_t now_ns) const {
  if (level_ == 0) return kNothing;
  if (level_ == 1) return moving(now_ns) ? kRays : kNothing;
  return still(now_ns) ? kNothing : static_cast<Reduction>(level_ - 1);
}

DeadlineState RateGovernor::in_force(std::int64_t now_ns) const {
  const Reduction reduction = reduction_at(now_ns);
  return {.level = level_,
          .measures = {.coarse = reduction >= kRays,
                       .wide_step = reduction >= kSteps,
                       .cheap_filters = reduction >= kFilters}};
}

std::optional<std::int64_t> RateGovernor::next_change_ns(std::int64_t now_ns) const {
  if (reduction_at(now_ns) == kNothing) return std::nullopt;
  return level_ == 1 ? last_moved_ns_ + kMovingNs : std::max(last_volume_ns_, last_moved_ns_) + kStillNs;
}

void RateGovernor::picture_finished(const PictureStamp& stamp) {
  if (scene_.deadline.plan != DeadlinePlan::kHoldRate) return;
  const std::int64_t now_ns = stamp.finished_time_ns;
  // A replaced frame makes no new volume, but a new picture that counts.
  const bool new_volume =
      stamp.volume.volume_id != last_volume_id_ || stamp.volume.last_frame_sequence != last_frame_sequence_;
  if (new_volume) {
    last_volume_id_ = stamp.volume.volume_id;
    last_frame_sequence_ = stamp.volume.last_frame_sequence;
    last_volume_ns_ = now_ns;
  }
  const bool has_cast = stamp.stage_ms[static_cast<std::size_t>(Stage::kCast)] > 0;
  // The single picture after the view came to rest has no rate to keep. A picture that was begun at another
  // level does not count either.
  const Reduction reduction = reduction_of(stamp);
  const bool of_the_level = level_ < 2 ? reduction <= level_ : reduction == level_ - 1;
  if (!has_cast || !of_the_level || !(new_volume || moving(now_ns))) return;

  if (reduction != measured_) {
    before_ms_ = median_ms_;
    before_ = measured_;
    measured_ = reduction;
    pictures_ = 0;
    median_ms_ = 0;
  }
  work_ms_[pictures_ % kFew] = work_ms(stamp);
  if (++pictures_ < kFew) return;
  std::array<double, kFew> sorted = work_ms_;
  std::ranges::sort(sorted);
  median_ms_ = sorted[kFew / 2];
  learn(median_ms_);

  if (median_ms_ > kLate * period_ms(scene_)) {
    if (level_ < kMostDeadlineLevel) change_level(static_cast<std::uint8_t>(level_ + 1), now_ns);
  } else if (level_ > 0 && now_ns - changed_ns_ >= stay_ns_ &&
             expected_below_ms(median_ms_) <= kFits * period_ms(scene_)) {
    change_level(static_cast<std::uint8_t>(level_ - 1), now_ns);
  }
}

void RateGovernor::learn(double median_ms) {
  if (before_ms_ <= 0 || median_ms <= 0) return;
  const bool more_reduced = measured_ == before_ + 1;
  if (more_reduced) gain_[measured_] = std::clamp(before_ms_ / median_ms, 1.0, kMostGain);
  if (before_ == measured_ + 1) gain_[before_] = std::clamp(median_ms / before_ms_, 1.0, kMostGain);
  before_ms_ = 0;
}

double RateGovernor::expected_below_ms(double median_ms) const {
  return median_ms * gain_[measured_];
}

void RateGovernor::change_level(std::uint8_t level, std::int64_t now_ns) {
  const bool down = level < level_;
  const bool regretted = !down && went_down_ && now_ns - changed_ns_ < kRegretNs;
  if (regretted) stay_ns_ = std::min(2 * stay_ns_, kLongestStayNs);
  if (now_ns - changed_ns_ > kLongestStayNs) stay_ns_ = kLeastStayNs;
  level_ = level;
  went_down_ = down;
  changed_ns_ = now_ns;
  pictures_ = 0;
}

Scene degraded(const Scene& requested, const DeadlineMeasures& measures, double finest_mm) {
  Scene scene = requested;
  if (measures.coarse) scene.rays.stride = 2;
  if (measures.wide_step) {
    const double least_mm =
        std::max(finest_mm, (requested.rays.end_mm - requested.rays.start_mm) / (kMostSamplesOnARay - 1));
    scene.rays.step_mm = 2 * sample_step_mm(requested, least_mm);
    scene.detector.window = 2 * ((requested.detector.window + 2) / 4);
  }
  if (measures.cheap_filters) {
    scene.speckle.filter = SpeckleFilter::kNone;
    scene.detector.frame_steps = FrameSteps::kKept;
    scene.filter.kind = DepthFilter::kMean;
    scene.filter.islands = 1;
    scene.filter.holes = 1;
    scene.finish.outline = 0;
  }
  return scene;
}

}  // namespace fanlight
