// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>

#include "proto/base/result.hpp"

namespace fanlight {

inline constexpr double kPi = 3.14159265358979323846;
constexpr double radians(double degrees) {
  return degrees * (kPi / 180.0);
}
constexpr double degrees(double radians) {
  return radians * (180.0 / kPi);
}

/// A point in the transducer frame, mm: origin at the centre of the probe face, x lateral (positive towards
/// the marked side), y into the body, z = x cross y (elevation). Right-handed.
struct Point {
  double x_mm = 0;
  double y_mm = 0;
  double z_mm = 0;
};

/// Position in a swept fan: the sweep angle about the motor axis, and the depth in the plane of the frame at
/// that angle.
struct FanCoordinate {
  double angle_rad = 0;
  double depth_mm = 0;
};

/// Layout of the pixels of a frame.
enum class FrameKind : std::uint8_t {
  kCartesian,    ///< scan converted by the scanner: columns are lateral, rows are depth
  kConvexLines,  ///< a column is a scan line of a curved array, a row a sample along it (polar)
  kLinearLines,  ///< a column is a scan line of a flat array; the lines are parallel
};

/// Their names in files, by FrameKind.
inline constexpr std::array<std::string_view, 3> kFrameKindNames = {"cartesian", "convex-lines",
                                                                    "linear-lines"};

/// Position in a frame, in columns and rows; pixel centres are at whole numbers.
struct FramePlace {
  double column = 0;
  double row = 0;
};

/// Position in the plane of a frame, mm: lateral, and depth below the centre of the probe face.
struct PlanePoint {
  double x_mm = 0;
  double depth_mm = 0;
};

/// Geometry of the pixels of a frame and of the motor angles.
///
/// The sweep axis is parallel to x at y = -motor_radius_mm; a frame at motor angle phi is the half plane
/// through that axis. In it, with rho the depth below the centre of the probe face:
///   Cartesian and linear lines   x = (column - face_column) * pixel_width_mm
///                                rho = (row - face_row) * pixel_height_mm
///   convex lines                 theta = (column - face_column) * line_pitch_deg
///                                r = probe_radius_mm + (row - face_row) * pixel_height_mm
///                                x = r sin theta, rho = r cos theta - probe_radius_mm
struct FanGeometry {
  FrameKind kind = FrameKind::kCartesian;
  std::uint32_t columns = 0;   ///< pixels across, or scan lines, ascending towards the marked side; 2 to 4096
  std::uint32_t rows = 0;      ///< pixels down a frame, or samples along a line; 2 to 4096
  double pixel_width_mm = 0;   ///< distance of columns, 0.001 to 10; unused for convex lines
  double pixel_height_mm = 0;  ///< distance of rows, or of samples along a line, 0.001 to 10
  double face_column = 0;      ///< column of the centre of the probe face; may be fractional
  double face_row = 0;         ///< row of the probe face; may be fractional or negative
  double motor_radius_mm = 0;  ///< distance of the sweep axis behind the probe face; above 0, up to 1000
  double probe_radius_mm = 0;  ///< radius of the array: its apex lies this far behind the face; 0 to 1000
  double line_pitch_deg = 0;   ///< convex lines only: angle between neighbouring lines, 0.001 to 10

  /// Scanned part of a Cartesian frame of a convex probe, where it is known. Pixels outside hold no echo, so
  /// their border with tissue is no surface. It begins at probe_radius_mm from the apex.
  struct Sector {
    double half_angle_deg = 0;  ///< to either side, up to 89; 0: the whole frame was scanned
    double reach_mm = 0;        ///< distance of the last sample from the apex; 0: down to the last row

    bool operator==(const Sector&) const = default;
  } sector;

  /// Cartesian frames only: grey level 0 means "not scanned", and echoes begin at 1. The border of what was
  /// not scanned is no surface. False: grey level 0 is the weakest echo.
  bool zero_is_unscanned = false;

  /// Cartesian frames only: they were cut from a volume on a grid, so where the beams came from is unknown.
  /// False: the beams came from the probe face.
  bool unknown_beams = false;

  bool operator==(const FanGeometry&) const = default;

  std::uint64_t frame_bytes() const { return std::uint64_t{columns} * rows; }
  bool polar() const { return kind == FrameKind::kConvexLines; }

  /// Position in the frame of a point in its plane; outside 0 to columns - 1 and 0 to rows - 1 for a point
  /// outside the frame.
  FramePlace frame_place(PlanePoint at) const {
    if (!polar()) return {at.x_mm / pixel_width_mm + face_column, at.depth_mm / pixel_height_mm + face_row};
    const double from_apex_mm = at.depth_mm + probe_radius_mm;
    return {degrees(std::atan2(at.x_mm, from_apex_mm)) / line_pitch_deg + face_column,
            (std::hypot(at.x_mm, from_apex_mm) - probe_radius_mm) / pixel_height_mm + face_row};
  }

  /// Inverse of frame_place().
  PlanePoint plane_point(FramePlace at) const {
    const double along_mm = (at.row - face_row) * pixel_height_mm;
    if (!polar()) return {(at.column - face_column) * pixel_width_mm, along_mm};
    const double theta_rad = line_angle_rad(at.column);
    const double radius_mm = probe_radius_mm + along_mm;
    return {radius_mm * std::sin(theta_rad), radius_mm * std::cos(theta_rad) - probe_radius_mm};
  }

  /// Convex lines only: angle of a line to the probe's axis, positive towards +x.
  double line_angle_rad(double column) const { return radians((column - face_column) * line_pitch_deg); }

  // Bounds of all pixel centres in the plane of a frame, mm.
  double left_mm() const;
  double right_mm() const;
  double nearest_mm() const;  ///< smallest in-plane depth; negative where a curved array bends away
  double depth_mm() const;    ///< largest in-plane depth

  /// Smallest distance of neighbouring pixels in a frame, mm; along the lines for convex ones.
  double finest_mm() const { return polar() ? pixel_height_mm : std::min(pixel_width_mm, pixel_height_mm); }

  /// Distances of neighbouring samples at a point of the body, mm: x across the lines, y along them, z
  /// between frames that are `frame_step_rad` apart.
  Point sample_distances(const Point& at, double frame_step_rad) const;

  /// phi = atan2(z, y + Rm), rho = hypot(z, y + Rm) - Rm, with Rm = motor_radius_mm.
  FanCoordinate fan_coordinate(double y_mm, double z_mm) const {
    const double from_axis_mm = y_mm + motor_radius_mm;
    return {std::atan2(z_mm, from_axis_mm), std::hypot(z_mm, from_axis_mm) - motor_radius_mm};
  }

  /// Inverse of fan_coordinate(): the point at a lateral position, an in-plane depth and a sweep angle.
  Point point(double x_mm, FanCoordinate at) const {
    const double from_axis_mm = at.depth_mm + motor_radius_mm;
    return {x_mm, from_axis_mm * std::cos(at.angle_rad) - motor_radius_mm,
            from_axis_mm * std::sin(at.angle_rad)};
  }
};

/// kInvalidArgument for the first field out of the range that its docstring gives.
Result<void> check(const FanGeometry& geometry);

}  // namespace fanlight
