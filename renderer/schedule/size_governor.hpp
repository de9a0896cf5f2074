// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "proto/model/picture.hpp"
#include "proto/model/picture_size.hpp"
#include "proto/model/scene.hpp"

namespace fanlight {

/// Chooses the size of the main view's pictures: the usual one, or a finer one where a display shows more
/// pixels and the machine has the time for them.
///
/// Has the time: while volumes come, a fine picture must take less than half the time from one volume to the
/// next, and of the period of DeadlinePlan::kHoldRate; while the scene changes, less than kMovingWorkMs.
/// Otherwise the usual size is in force, and the fine picture comes when the scene and the volume rest, after
/// a whole one of the usual size: it refines that. It is never so large that it would take more than
/// kMostWorkMs; and where the server lights it, than kMostLightMs for passes 2 and 3, so that a moved light
/// is seen soon.
///
/// With Refresh::kFrame the usual size stays: frames are replaced at any time.
///
/// The work counts as proportional to the pixels, as of the last whole picture of the usual size; or of a
/// finer one since then, where that took clearly less: the first picture also pays for the shaders.
///
/// One thread; its clock is fanlight::now_ns or a simulated one. No function blocks or allocates.
class SizeGovernor {
 public:
  /// A scene or a volume rests after this time without another. A changed light counts until the fine picture
  /// is there: a picture that is being refined is not lit.
  static constexpr std::int64_t kRestNs = 600'000'000;
  /// A volume that is not one of the cine counts as the last one after this time without another.
  static constexpr std::int64_t kStillNs = 2'000'000'000;
  static constexpr double kMostWorkMs = 1500;
  static constexpr double kMostLightMs = 100;
  /// Work that a changing scene may take for each picture.
  static constexpr double kMovingWorkMs = 16;
  /// After a fine picture took too long while volumes come, none is tried for this time.
  static constexpr std::int64_t kBackOffNs = 10'000'000'000;

  /// The proportions of all sizes are those of `usual`.
  SizeGovernor(PictureSize usual, PictureSize largest) : usual_(usual), largest_(largest) {}

  /// Of a renderer that was made again, whose first picture pays for the shaders again.
  void set_largest(PictureSize largest) {
    largest_ = largest;
    usual_measured_ = 0;
  }

  void want(const WantedSizes& wanted) { wanted_ = wanted; }

  void scene_came(const NumberedScene& scene, std::int64_t now_ns);

  /// Whether one of the kept volumes is shown, and stays.
  void set_frozen(bool frozen) { frozen_ = frozen; }

  /// A volume is about to be cast, a new one or one of those that are kept.
  void volume_came(std::int64_t now_ns) {
    volume_ns_ = now_ns;
    whole_is_shown_ = fine_is_shown_ = false;
  }

  /// To be called for every picture, in the order in which they were finished.
  void picture_finished(const Picture& picture);

  /// The size of pictures that are begun at that time; absent: the usual one.
  std::optional<PictureSize> in_force(std::int64_t now_ns) const;

  /// When in_force() may change without further calls; absent where it does not.
  std::optional<std::int64_t> next_change_ns(std::int64_t now_ns) const;

 private:
  double factor_to(std::optional<PictureSize> wanted) const;
  std::optional<PictureSize> fine() const;
  double work_ms(PictureSize size) const;
  /// When the scene, or the volume on show, counts as resting.
  std::int64_t scene_rests_ns() const { return changed_ns_ + kRestNs; }
  std::int64_t volume_rests_ns() const { return volume_ns_ + (frozen_ ? kRestNs : kStillNs); }

  PictureSize usual_;
  PictureSize largest_;
  WantedSizes wanted_;
  Scene scene_;
  bool has_scene_ = false;
  bool frozen_ = false;
  std::uint64_t moved_revision_ = 0;    // of the last scene that moved the view
  std::int64_t changed_ns_ = -kRestNs;  // the scene
  std::uint64_t volume_id_ = 0;
  std::int64_t volume_ns_ = 0;        // when it came
  std::int64_t volume_shown_ns_ = 0;  // when its first picture was finished
  double period_ms_ = 0;              // from volume to volume, a mean of the last ones; 0: not known
  double work_ms_per_pixel_ = 0;      // 0: not known
  double light_ms_per_pixel_ = 0;     // the part of passes 2 and 3
  std::uint64_t usual_measured_ = 0;  // pictures of the usual size whose work is known
  bool whole_is_shown_ = false;       // of the view and the volume, a picture with a ray for each pixel
  bool fine_is_shown_ = false;        // the same in a finer size
  std::int64_t backed_off_ns_ = -kBackOffNs;
};

}  // namespace fanlight
