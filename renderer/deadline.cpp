#include "renderer/deadline.hpp"

#include <algorithm>
#include <numeric>

namespace fanlight {

namespace {

constexpr double kLate = 1.1;  // of the wanted period
constexpr double kFits = 0.8;
// Nothing that is taken saves more; what seems to was cheap for another reason.
constexpr double kMostWorth = 4;
// A level that had to be entered again within this time was left too early.
constexpr std::int64_t kRegretNs = 10'000'000'000;
constexpr std::int64_t kLongestStayNs = 60'000'000'000;

double period_ms(const Scene& scene) {
  return 1000 / scene.deadline.rate_hz;
}

}  // namespace

void Deadline::scene_came(const Scene& scene, std::int64_t now_ns) {
  if (scene.deadline.plan == DeadlinePlan::kOff) {
    *this = Deadline();
  } else if (known_scene_ && first_pass_changed(scene_, scene) <= FirstPass::kCast) {
    last_moved_ns_ = now_ns;
  }
  scene_ = scene;
  known_scene_ = true;
}

Deadline::Taken Deadline::taken_from(const PictureStamp& stamp) {
  const DeadlineMeasures& measures = stamp.measures;
  if (measures.cheap_filters) return kFilters;
  if (measures.wide_step) return kSteps;
  return measures.coarse ? kRays : kNothing;
}

bool Deadline::still(std::int64_t now_ns) const {
  return now_ns >= std::max(last_volume_ns_, last_moved_ns_) + kStillNs;
}

Deadline::Taken Deadline::taken_at(std::int64_t now_ns) const {
  if (level_ == 0) return kNothing;
  if (level_ == 1) return moving(now_ns) ? kRays : kNothing;
  return still(now_ns) ? kNothing : static_cast<Taken>(level_ - 1);
}

DeadlineState Deadline::in_force(std::int64_t now_ns) const {
  const Taken taken = taken_at(now_ns);
  return {.level = level_,
          .measures = {
              .coarse = taken >= kRays, .wide_step = taken >= kSteps, .cheap_filters = taken >= kFilters}};
}

std::optional<std::int64_t> Deadline::next_change_ns(std::int64_t now_ns) const {
  if (taken_at(now_ns) == kNothing) return std::nullopt;
  return level_ == 1 ? last_moved_ns_ + kMovingNs : std::max(last_volume_ns_, last_moved_ns_) + kStillNs;
}

void Deadline::picture_finished(const PictureStamp& stamp) {
  if (scene_.deadline.plan == DeadlinePlan::kOff) return;
  const std::int64_t now_ns = stamp.finished_time_ns;
  // A frame that replaces another makes no new volume, but a picture that was waited for.
  const bool new_volume =
      stamp.volume.volume_id != last_volume_id_ || stamp.volume.last_frame_sequence != last_frame_sequence_;
  if (new_volume) {
    last_volume_id_ = stamp.volume.volume_id;
    last_frame_sequence_ = stamp.volume.last_frame_sequence;
    last_volume_ns_ = now_ns;
  }
  const bool has_cast = stamp.stage_ms[static_cast<std::size_t>(Stage::kCast)] > 0;
  // One picture when the view has come to rest has no rate to hold, nor has one that was begun at another
  // level.
  const Taken taken = taken_from(stamp);
  const bool of_the_level = level_ < 2 ? taken <= level_ : taken == level_ - 1;
  if (!has_cast || !of_the_level || !(new_volume || moving(now_ns))) return;

  if (taken != measured_) {
    before_ms_ = median_ms_;
    before_ = measured_;
    measured_ = taken;
    pictures_ = 0;
    median_ms_ = 0;
  }
  work_ms_[pictures_ % kFew] = std::accumulate(stamp.stage_ms.begin(), stamp.stage_ms.end(), 0.0);
  if (++pictures_ < kFew) return;
  std::array<double, kFew> sorted = work_ms_;
  std::ranges::sort(sorted);
  median_ms_ = sorted[kFew / 2];
  learn(median_ms_);

  if (median_ms_ > kLate * period_ms(scene_)) {
    if (level_ < kMostDeadlineLevel) go(static_cast<std::uint8_t>(level_ + 1), now_ns);
  } else if (level_ > 0 && now_ns - changed_ns_ >= stay_ns_ &&
             expected_below_ms(median_ms_) <= kFits * period_ms(scene_)) {
    go(static_cast<std::uint8_t>(level_ - 1), now_ns);
  }
}

void Deadline::learn(double median_ms) {
  if (before_ms_ <= 0 || median_ms <= 0) return;
  const bool deeper = measured_ == before_ + 1;
  if (deeper) worth_[measured_] = std::clamp(before_ms_ / median_ms, 1.0, kMostWorth);
  if (before_ == measured_ + 1) worth_[before_] = std::clamp(median_ms / before_ms_, 1.0, kMostWorth);
  before_ms_ = 0;
}

double Deadline::expected_below_ms(double median_ms) const {
  return median_ms * worth_[measured_];
}

void Deadline::go(std::uint8_t level, std::int64_t now_ns) {
  const bool down = level < level_;
  const bool regretted = !down && went_down_ && now_ns - changed_ns_ < kRegretNs;
  if (regretted) stay_ns_ = std::min(2 * stay_ns_, kLongestStayNs);
  if (now_ns - changed_ns_ > kLongestStayNs) stay_ns_ = kLeastStayNs;
  level_ = level;
  went_down_ = down;
  changed_ns_ = now_ns;
  pictures_ = 0;
}

Scene planned(const Scene& asked, const DeadlineMeasures& measures, double finest_mm) {
  Scene scene = asked;
  if (measures.coarse) scene.rays.stride = 2;
  if (measures.wide_step) {
    const double least_mm =
        std::max(finest_mm, (asked.rays.end_mm - asked.rays.start_mm) / (kMostSamplesOnARay - 1));
    scene.rays.step_mm = 2 * (asked.rays.step_mm > 0 ? asked.rays.step_mm : least_mm);
    scene.detector.window = 2 * ((asked.detector.window + 2) / 4);
  }
  if (measures.cheap_filters) {
    scene.speckle.filter = SpeckleFilter::kNone;
    scene.filter.kind = DepthFilter::kMean;
    scene.filter.islands = 1;
    scene.filter.holes = 1;
  }
  return scene;
}

}  // namespace fanlight
