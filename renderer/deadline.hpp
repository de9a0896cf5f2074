#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "proto/picture.hpp"
#include "proto/scene.hpp"

namespace fanlight {

/// Holds the rate of pictures that a scene names (deadline.plan, deadline.rate_hz) on a machine that cannot
/// keep up: level by level it takes from the pictures, and gives back what fits again.
///
/// A level up where the median work of the last few pictures exceeds the wanted period by a tenth; a level
/// down where the work expected there fits into four fifths of it. Between the two nothing changes. What a
/// level costs is learned while it is entered and left. A level that was left too early is left later next
/// time.
///
/// The work counts, not the time between pictures: pictures that come seldom because nothing moves are not
/// late. A picture that casts no ray counts for nothing either; no level would make it cheaper.
///
/// One thread, whose clock is fanlight::now_ns or a made-up one. No function blocks or allocates.
class Deadline {
 public:
  /// The view moves until so long after the last change that casts rays. A moved light is not meant: what it
  /// costs does not depend on the rays.
  static constexpr std::int64_t kMovingNs = 300'000'000;
  /// Where for so long neither the view moves nor a new volume comes, the picture may take the time to be
  /// full, whatever the level.
  static constexpr std::int64_t kStillNs = 2'000'000'000;
  /// A level stays in force for so long at least before a lower one is tried.
  static constexpr std::int64_t kLeastStayNs = 2'000'000'000;

  /// The scene that is asked for from now on.
  void scene_came(const Scene& scene, std::int64_t now_ns);

  /// Of every picture, in the order in which they were finished.
  void picture_finished(const PictureStamp& stamp);

  /// What pictures that are begun at that time are to be made with.
  DeadlineState in_force(std::int64_t now_ns) const;

  /// When in_force() will say something else though nothing is told meanwhile; absent: it will not.
  std::optional<std::int64_t> next_change_ns(std::int64_t now_ns) const;

 private:
  // Each takes more from a picture than the one before; a level is in force through one of them.
  enum Taken : std::uint8_t { kNothing, kRays, kSteps, kFilters, kTakens };
  static constexpr std::size_t kFew = 3;  // pictures whose median counts

  static Taken taken_from(const PictureStamp& stamp);
  Taken taken_at(std::int64_t now_ns) const;
  bool moving(std::int64_t now_ns) const { return now_ns < last_moved_ns_ + kMovingNs; }
  bool still(std::int64_t now_ns) const;
  void learn(double median_ms);
  double expected_below_ms(double median_ms) const;
  void go(std::uint8_t level, std::int64_t now_ns);

  Scene scene_;
  bool known_scene_ = false;
  std::uint8_t level_ = 0;
  std::int64_t last_moved_ns_ = -kMovingNs;
  std::int64_t last_volume_ns_ = 0;
  std::uint64_t last_volume_id_ = 0;
  std::uint64_t last_frame_sequence_ = 0;

  // Of the pictures since the level or what is taken changed: work.
  std::array<double, kFew> work_ms_{};
  std::size_t pictures_ = 0;
  Taken measured_ = kNothing;

  // The last median before that change, 0 for none, and what was taken then.
  double before_ms_ = 0;
  Taken before_ = kNothing;
  double median_ms_ = 0;
  // Of each of them: so many times the work it would be without it, with the one before.
  std::array<double, kTakens> worth_ = {1, 4, 2, 2};

  std::int64_t changed_ns_ = 0;  // the level
  bool went_down_ = false;       // then
  std::int64_t stay_ns_ = kLeastStayNs;
};

/// The scene that is rendered for `asked`: that scene, but for the fields that the measures change.
/// `finest_mm` is the step that rays.step_mm = 0 stands for. A wide step has half the samples in the
/// detector's window, so that the window spans what it did.
Scene planned(const Scene& asked, const DeadlineMeasures& measures, double finest_mm);

}  // namespace fanlight
