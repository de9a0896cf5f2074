#pragma once

#include <cmath>
#include <cstdint>
#include <string>

#include "proto/result.hpp"

namespace fanlight {

inline constexpr double kPi = 3.14159265358979323846;
constexpr double radians(double degrees) {
  return degrees * (kPi / 180.0);
}
constexpr double degrees(double radians) {
  return radians * (180.0 / kPi);
}

/// A point in the transducer frame, mm: origin at the centre of the probe face, x lateral (marked side
/// positive), y into the body, z = x cross y (elevation). Right-handed.
struct Point {
  double x_mm = 0;
  double y_mm = 0;
  double z_mm = 0;
};

/// Where a point lies in a swept fan: the sweep angle about the motor axis and the depth in the plane of
/// the frame at that angle.
struct FanCoordinate {
  double angle_rad = 0;
  double depth_mm = 0;
};

/// How the pixels of a Cartesian (scan converted) frame and the angles of the motor lie in space.
///
/// The sweep axis is parallel to x at y = -motor_radius_mm; a frame at motor angle phi is the half plane
/// through that axis (design, section 3). Pixel (column, row) has its centre at
///   x   = (column - face_column) * pixel_width_mm
///   rho = (row - face_row) * pixel_height_mm     (in-plane depth below the probe face)
struct FanGeometry {
  std::uint32_t columns = 0;   ///< pixels across a frame (lateral), 2 to 4096
  std::uint32_t rows = 0;      ///< pixels down a frame (depth), 2 to 4096
  double pixel_width_mm = 0;   ///< 0.001 to 10
  double pixel_height_mm = 0;  ///< 0.001 to 10
  double face_column = 0;      ///< column of the centre of the probe face, may be fractional
  double face_row = 0;         ///< row of the centre of the probe face, may be fractional or negative
  double motor_radius_mm = 0;  ///< distance of the sweep axis behind the probe face, above 0 to 1000

  /// The part of a frame that a convex probe scans, where it is known; pixels outside it hold no echo, so
  /// that their border with tissue is no surface. The apex lies probe_radius_mm behind the probe face.
  struct Sector {
    double probe_radius_mm = 0;  ///< 0 to 1000; the scanned part begins at this distance from the apex
    double half_angle_deg = 0;   ///< to either side, up to 89; 0: every pixel of the frame was scanned
    double reach_mm = 0;         ///< distance of the last sample from the apex; 0: down to the last row

    bool operator==(const Sector&) const = default;
  } sector;

  bool operator==(const FanGeometry&) const = default;

  std::uint64_t frame_bytes() const { return std::uint64_t{columns} * rows; }

  /// In-plane depth of the last row's centre, mm.
  double depth_mm() const { return (rows - 1 - face_row) * pixel_height_mm; }

  /// Lateral position of the first and last column's centre, mm.
  double left_mm() const { return -face_column * pixel_width_mm; }
  double right_mm() const { return (columns - 1 - face_column) * pixel_width_mm; }

  /// phi = atan2(z, y + Rm), rho = hypot(z, y + Rm) - Rm (design, section 3).
  FanCoordinate fan_coordinate(double y_mm, double z_mm) const {
    const double from_axis_mm = y_mm + motor_radius_mm;
    return {std::atan2(z_mm, from_axis_mm), std::hypot(z_mm, from_axis_mm) - motor_radius_mm};
  }

  /// The inverse: the point at lateral position x_mm, in-plane depth and sweep angle.
  Point point(double x_mm, FanCoordinate at) const {
    const double from_axis_mm = at.depth_mm + motor_radius_mm;
    return {x_mm, from_axis_mm * std::cos(at.angle_rad) - motor_radius_mm,
            from_axis_mm * std::sin(at.angle_rad)};
  }
};

/// Every field within the range its docstring gives, or the first one that is not.
Result<void> check(const FanGeometry& geometry);

}  // namespace fanlight
