// SPDX-License-Identifier: Apache-2.0
#include "renderer/schedule/size_governor.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace fanlight {

namespace {

// Of the time between two volumes.
constexpr double kFitsBetweenVolumes = 0.5;
constexpr double kTooSlow = 0.95;
// Weight of the newest interval in the mean.
constexpr double kNewest = 0.25;
// A picture of almost the usual size is not worth another cast.
constexpr double kLeastGain = 1.1;
// As long as only the first picture is measured, which also pays for the shaders, one that is so much larger
// is tried whatever that took: a volume that stays would otherwise stay coarse.
constexpr double kTriedGain = 1.2;
// A finer picture that takes less than this share of what was expected corrects the expectation.
constexpr double kOverestimated = 0.6;

double total_ms(const PictureStamp& stamp) {
  return std::accumulate(stamp.stage_ms.begin(), stamp.stage_ms.end(), 0.0);
}

double light_ms(const PictureStamp& stamp) {
  const auto filter = stamp.stage_ms.begin() + static_cast<std::ptrdiff_t>(Stage::kFilter);
  return std::accumulate(filter, stamp.stage_ms.end(), 0.0);
}

PictureSize scaled(PictureSize size, double factor) {
  const auto side = [factor](std::uint32_t pixels) {
    return static_cast<std::uint32_t>(std::lround(pixels * factor));
  };
  return {.width = side(size.width), .height = side(size.height)};
}

/// By how much `size` may be larger and still fit into `into`.
double factor_into(PictureSize size, PictureSize into) {
  return std::min(static_cast<double>(into.width) / size.width,
                  static_cast<double>(into.height) / size.height);
}

}  // namespace

void SizeGovernor::scene_came(const NumberedScene& scene, std::int64_t now_ns) {
  const FirstPass changed = has_scene_ ? first_pass_changed(scene_, scene.scene) : FirstPass::kCast;
  if (changed != FirstPass::kNone) changed_ns_ = now_ns;
  if (changed <= FirstPass::kCast) {
    moved_revision_ = scene.revision;
    whole_is_shown_ = fine_is_shown_ = false;
  }
  scene_ = scene.scene;
  has_scene_ = true;
}

void SizeGovernor::picture_finished(const Picture& picture) {
  const PictureStamp& stamp = picture.stamp;
  const bool has_cast = stamp.stage_ms[static_cast<std::size_t>(Stage::kCast)] > 0;
  const PictureSize size{.width = picture.width, .height = picture.height};
  if (stamp.volume.volume_id != volume_id_) {
    const double passed_ms = static_cast<double>(stamp.finished_time_ns - volume_shown_ns_) / 1e6;
    const bool in_a_row = volume_id_ > 0 && passed_ms < kStillNs / 1e6;
    if (!in_a_row) {
      period_ms_ = 0;
    } else {
      period_ms_ += (passed_ms - period_ms_) * (period_ms_ > 0 ? kNewest : 1);
    }
    volume_id_ = stamp.volume.volume_id;
    volume_shown_ns_ = stamp.finished_time_ns;
    const bool too_slow = has_cast && in_a_row && size != usual_ && total_ms(stamp) > kTooSlow * period_ms_;
    if (too_slow) backed_off_ns_ = stamp.finished_time_ns;
  }
  if (!has_cast || stamp.measures != DeadlineMeasures{}) return;
  const double ms_per_pixel = total_ms(stamp) / static_cast<double>(size.pixels());
  // Of fine ones only where the difference is large: their size would else change with each of them.
  if (size == usual_) ++usual_measured_;
  if (size == usual_ || ms_per_pixel < kOverestimated * work_ms_per_pixel_) {
    work_ms_per_pixel_ = ms_per_pixel;
    light_ms_per_pixel_ = light_ms(stamp) / static_cast<double>(size.pixels());
  }
  if (stamp.scene_revision < moved_revision_) return;
  whole_is_shown_ = true;
  fine_is_shown_ = size != usual_;
}

double SizeGovernor::work_ms(PictureSize size) const {
  return work_ms_per_pixel_ * static_cast<double>(size.pixels());
}

/// By how much pictures may be larger than usual for displays that want that size.
double SizeGovernor::factor_to(std::optional<PictureSize> wanted) const {
  if (!wanted) return 1;
  const double tried = usual_measured_ < 2 ? kTriedGain : 1;
  return std::min({factor_into(usual_, *wanted), factor_into(usual_, largest_),
                   std::max(tried, std::sqrt(kMostWorkMs / work_ms(usual_)))});
}

/// The finest size that is asked for and possible; absent where it is hardly more than the usual one.
std::optional<PictureSize> SizeGovernor::fine() const {
  if (work_ms_per_pixel_ <= 0) return std::nullopt;
  const double light_ms = light_ms_per_pixel_ * static_cast<double>(usual_.pixels());
  const double quickly_lit =
      light_ms > 0 ? std::sqrt(kMostLightMs / light_ms) : factor_into(usual_, largest_);
  // Displays do not light glass themselves.
  const double of_surfaces = factor_to(wanted_.of_surfaces);
  const double factor = std::max(is_glass(scene_) ? std::min(of_surfaces, quickly_lit) : of_surfaces,
                                 std::min(factor_to(wanted_.of_pictures), quickly_lit));
  if (factor < kLeastGain) return std::nullopt;
  return scaled(usual_, factor);
}

std::optional<PictureSize> SizeGovernor::in_force(std::int64_t now_ns) const {
  const auto size = fine();
  if (!size || scene_.refresh == Refresh::kFrame) return std::nullopt;
  const double ms = work_ms(*size);
  const bool fits_a_change = ms <= kMovingWorkMs;
  if (now_ns < scene_rests_ns() && !fits_a_change && !fine_is_shown_) return std::nullopt;
  const bool holds_rate = scene_.deadline.plan == DeadlinePlan::kHoldRate;
  const double period_ms = holds_rate ? std::min(period_ms_, 1000 / scene_.deadline.rate_hz) : period_ms_;
  const bool fits_a_volume =
      period_ms > 0 && ms < kFitsBetweenVolumes * period_ms && now_ns >= backed_off_ns_ + kBackOffNs;
  if (now_ns < volume_rests_ns() && !fits_a_volume) return std::nullopt;
  return whole_is_shown_ || fits_a_change || fits_a_volume ? size : std::nullopt;
}

std::optional<std::int64_t> SizeGovernor::next_change_ns(std::int64_t now_ns) const {
  if (!fine()) return std::nullopt;
  std::optional<std::int64_t> next;
  for (const std::int64_t each : {scene_rests_ns(), volume_rests_ns(), backed_off_ns_ + kBackOffNs}) {
    if (each > now_ns) next = std::min(next.value_or(each), each);
  }
  return next;
}

}  // namespace fanlight
