#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace fanlight {

/// The look-up table of the paper, from a place in the body to the frame coordinate, so that the ray caster
/// reads the frames without resampling them into a grid. The coordinate depends on the sweep angle alone,
/// so one axis is enough: entries are even in tan(angle / 2), which a point (y, z) gives without an arc
/// function as z / (hypot(z, y + Rm) + y + Rm), and which is nearly even in the angle itself.
///
/// entries(): the frame coordinate among the frames in ascending order of angle, 0 for the first, linear in
/// the angle between each two, and so for frames at uneven angles; extrapolated beyond the first and last.
class AngleTable {
 public:
  /// A table for up to frame_capacity frames, most of them between the two angles; all angles lie within
  /// +-90 deg. All memory is allocated here.
  AngleTable(double first_angle_rad, double last_angle_rad, std::uint32_t frame_capacity);

  /// Fills in the frame coordinates of frames at these angles, ascending. Where their sweep is wider than the
  /// constructor was told, the entries are spread to cover that too, for these frames alone. Precondition: at
  /// least two different angles. Allocates nothing. False where the angles are those of the last call, so
  /// that nothing changed.
  bool place(std::span<const double> angles_rad);

  std::span<const float> entries() const { return entries_; }

  /// tan(angle / 2) times scale plus offset is the place in entries().
  double scale() const { return scale_; }
  double offset() const { return offset_; }

 private:
  void span(double first_angle_rad, double last_angle_rad);

  double expected_first_rad_;
  double expected_last_rad_;
  double first_rad_ = 0;  // that the entries span
  double last_rad_ = 0;
  double scale_ = 0;
  double offset_ = 0;
  std::vector<double> angles_;  // of each entry, rad
  std::vector<float> entries_;
  std::vector<double> placed_angles_;  // those of the last place(), ascending
  std::uint32_t placed_frames_ = 0;
};

}  // namespace fanlight
