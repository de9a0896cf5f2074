// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "proto/model/picture.hpp"
#include "proto/model/scene.hpp"

namespace fanlight {

/// Keeps the picture rate that a scene asks for (deadline.plan, deadline.rate_hz) on a machine that is too
/// slow for it: reduces the work per picture level by level, and restores it when it fits again.
///
/// The level rises where the median work of the last few pictures exceeds the wanted period by a tenth. It
/// falls where the work expected at the lower level fits into four fifths of the period. In between it stays.
/// The cost of a level is learned when the level is entered and left. A level that was left too early is kept
/// longer the next time.
///
/// With DeadlinePlan::kSmoothWhileMoving the level is 1 and stays.
///
/// The work per picture counts, not the time between pictures: pictures that are rare because nothing moves
/// are not late. A picture that casts no rays does not count, because no level would make it cheaper.
///
/// One thread; its clock is fanlight::now_ns or a simulated one. No function blocks or allocates.
class RateGovernor {
 public:
  /// The view counts as moving for this time after the last change that casts rays. A changed light does not
  /// count: its cost does not depend on the rays.
  static constexpr std::int64_t kMovingNs = 300'000'000;
  /// After this time without a moved view or a new volume, the picture may take the time of full quality, at
  /// every level.
  static constexpr std::int64_t kStillNs = 2'000'000'000;
  /// A level stays in force for at least this time before a lower one is tried.
  static constexpr std::int64_t kLeastStayNs = 2'000'000'000;

  /// Sets the requested scene.
  void scene_came(const Scene& scene, std::int64_t now_ns);

  /// To be called for every picture, in the order in which they were finished.
  void picture_finished(const PictureStamp& stamp);

  /// The level and measures for pictures that are begun at that time.
  DeadlineState in_force(std::int64_t now_ns) const;

  /// When in_force() changes without further calls; absent where it does not.
  std::optional<std::int64_t> next_change_ns(std::int64_t now_ns) const;

 private:
  // Reductions of the work per picture; each contains the one before. A level applies one of them.
  enum Reduction : std::uint8_t { kNothing, kRays, kSteps, kFilters, kReductions };
  static constexpr std::size_t kFew = 3;  // number of pictures that the median is of

  static Reduction reduction_of(const PictureStamp& stamp);
  Reduction reduction_at(std::int64_t now_ns) const;
  bool moving(std::int64_t now_ns) const { return now_ns < last_moved_ns_ + kMovingNs; }
  bool still(std::int64_t now_ns) const;
  void learn(double median_ms);
  double expected_below_ms(double median_ms) const;
  void change_level(std::uint8_t level, std::int64_t now_ns);

  Scene scene_;
  bool has_scene_ = false;
  std::uint8_t level_ = 0;
  std::int64_t last_moved_ns_ = -kMovingNs;
  std::int64_t last_volume_ns_ = 0;
  std::uint64_t last_volume_id_ = 0;
  std::uint64_t last_frame_sequence_ = 0;

  // Work of the pictures since the level or the reduction changed.
  std::array<double, kFew> work_ms_{};
  std::size_t pictures_ = 0;
  Reduction measured_ = kNothing;

  // The last median before that change, 0 for none, and the reduction then.
  double before_ms_ = 0;
  Reduction before_ = kNothing;
  double median_ms_ = 0;
  // For each reduction: the work with the reduction before it, divided by the work with it.
  std::array<double, kReductions> gain_ = {1, 4, 2, 2};

  std::int64_t changed_ns_ = 0;  // when the level changed
  bool went_down_ = false;       // at that change
  std::int64_t stay_ns_ = kLeastStayNs;
};

/// The scene that is rendered for `requested`: the same but for the fields that the measures change.
/// `finest_mm` is the step that rays.step_mm = 0 stands for. With a wide step the detector's window has half
/// the samples, so that it spans the same distance.
Scene degraded(const Scene& requested, const DeadlineMeasures& measures, double finest_mm);

}  // namespace fanlight
