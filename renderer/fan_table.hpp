#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "proto/fan_geometry.hpp"
#include "proto/volume.hpp"

namespace fanlight {

/// The look-up table of the paper (design, section 3): over a grid of (y, z) it holds the in-plane depth and
/// the frame coordinate, so that the ray caster reads the frames without resampling them into a grid.
///
/// texels(): height() rows along y, width() columns along z, row major; x is rho in mm, y is the frame
/// coordinate among the frames in ascending order of angle, 0 for the first, extrapolated beyond the first
/// and last so that it stays linear at the border of the fan. The grid reaches two texels beyond the fan on
/// every side, where every texel's value lies outside the fan.
class FanTable {
 public:
  /// The grid and the depths for up to frame_capacity frames between the two angles; the frame coordinates
  /// come with place(). All memory is allocated here.
  FanTable(const FanGeometry& geometry, double first_angle_rad, double last_angle_rad,
           std::uint32_t frame_capacity);

  /// Fills in the frame coordinates of a volume whose angles lie where the constructor was told.
  /// Precondition: sorted by angle, at least two different angles. Allocates nothing. False where the angles
  /// are those of the last call, so that nothing changed.
  bool place(const Volume& volume);

  std::uint32_t width() const { return width_; }
  std::uint32_t height() const { return height_; }
  std::span<const glm::vec2> texels() const { return texels_; }

  /// (y, z) in mm times scale plus offset is the texture coordinate, 0 to 1, in the order (z, y).
  struct Axis {
    double scale;
    double offset;
  };
  Axis z_axis() const { return axis(z_first_mm_, width_); }
  Axis y_axis() const { return axis(y_first_mm_, height_); }

  /// The box around the fan, mm.
  struct Box {
    Point lowest;
    Point highest;
  };
  const Box& box() const { return box_; }

 private:
  Axis axis(double first_mm, std::uint32_t texels) const;

  double texel_mm_ = 0;
  double y_first_mm_ = 0;  // of the first texel's centre
  double z_first_mm_ = 0;
  std::uint32_t width_ = 0;
  std::uint32_t height_ = 0;
  Box box_;
  std::vector<double> angles_;  // of each texel, rad
  std::vector<glm::vec2> texels_;
  std::vector<double> placed_angles_;  // those of the last place(), ascending
  std::uint32_t placed_frames_ = 0;
};

}  // namespace fanlight
