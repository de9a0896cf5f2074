// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace fanlight {

/// The look-up table of the paper. It maps a point in the body to a frame coordinate, so that the ray caster
/// reads the frames without resampling them into a grid. The coordinate depends on the sweep angle only, so
/// one axis is enough. Entries are spaced evenly in tan(angle / 2), which a point (y, z) gives without an arc
/// function as z / (hypot(z, y + Rm) + y + Rm), and which is nearly even in the angle itself.
///
/// entries(): the frame coordinate among the frames in ascending order of angle. 0 is the first frame;
/// between two frames the coordinate is linear in the angle, also for frames at uneven angles; beyond the
/// first and last frame it is extrapolated.
class AngleTable {
 public:
  /// A table for up to frame_capacity frames, most of them between the two angles. All angles lie within +-90
  /// deg. Allocates all memory.
  AngleTable(double first_angle_rad, double last_angle_rad, std::uint32_t frame_capacity);

  /// Computes the entries for frames at these angles, ascending. Where the sweep is wider than the
  /// constructor's angles, the entries span the wider sweep, for these frames only. Precondition: at least
  /// two different angles. Allocates nothing. Returns false where the angles equal those of the last call, so
  /// that nothing changed.
  bool update(std::span<const double> angles_rad);

  std::span<const float> entries() const { return entries_; }

  /// tan(angle / 2) * scale() + offset() is the index in entries().
  double scale() const { return scale_; }
  double offset() const { return offset_; }

 private:
  void set_span(double first_angle_rad, double last_angle_rad);

  double expected_first_rad_;
  double expected_last_rad_;
  double first_rad_ = 0;  // range that the entries span
  double last_rad_ = 0;
  double scale_ = 0;
  double offset_ = 0;
  std::vector<double> entry_angles_rad_;
  std::vector<float> entries_;
  std::vector<double> frame_angles_rad_;  // of the last update(), ascending
  std::uint32_t frames_ = 0;
};

}  // namespace fanlight
