// SPDX-License-Identifier: Apache-2.0
#include "proto/model/fan_geometry.hpp"

#include <fmt/format.h>

#include <cmath>

namespace fanlight {

namespace {

struct Bound {
  const char* name;
  double value;
  double minimum;
  double maximum;
};

// Beyond this angle a line is parallel to the probe's face.
constexpr double kWidestLineDeg = 89;

/// Smallest or largest value over the corners of a frame; for convex lines also straight ahead, where the
/// depth has its only extremum between lines.
template <typename Value, typename Pick>
double over_frame(const FanGeometry& geometry, Value value, Pick pick) {
  const double last_column = geometry.columns - 1;
  const double last_row = geometry.rows - 1;
  double found = value(geometry.plane_point({0, 0}));
  for (const double column : {0.0, std::clamp(geometry.face_column, 0.0, last_column), last_column}) {
    for (const double row : {0.0, last_row}) found = pick(found, value(geometry.plane_point({column, row})));
  }
  return found;
}

constexpr auto kSmaller = [](double a, double b) { return std::min(a, b); };
constexpr auto kLarger = [](double a, double b) { return std::max(a, b); };
constexpr auto kLateral = [](PlanePoint at) { return at.x_mm; };
constexpr auto kDepth = [](PlanePoint at) { return at.depth_mm; };

}  // namespace

double FanGeometry::left_mm() const {
  return over_frame(*this, kLateral, kSmaller);
}
double FanGeometry::right_mm() const {
  return over_frame(*this, kLateral, kLarger);
}
double FanGeometry::nearest_mm() const {
  return over_frame(*this, kDepth, kSmaller);
}
double FanGeometry::depth_mm() const {
  return over_frame(*this, kDepth, kLarger);
}

Point FanGeometry::sample_distances(const Point& at, double frame_step_rad) const {
  const double depth_mm = fan_coordinate(at.y_mm, at.z_mm).depth_mm;
  const double across_mm =
      polar() ? radians(line_pitch_deg) * std::hypot(at.x_mm, depth_mm + probe_radius_mm) : pixel_width_mm;
  return {across_mm, pixel_height_mm, std::abs(frame_step_rad) * (depth_mm + motor_radius_mm)};
}

Result<void> check(const FanGeometry& geometry) {
  const Bound bounds[] = {
      {"columns", static_cast<double>(geometry.columns), 2, 4096},
      {"rows", static_cast<double>(geometry.rows), 2, 4096},
      {"pixel_width_mm", geometry.polar() ? 1 : geometry.pixel_width_mm, 0.001, 10},
      {"pixel_height_mm", geometry.pixel_height_mm, 0.001, 10},
      {"face_column", geometry.face_column, -100'000, 100'000},
      {"face_row", geometry.face_row, -100'000, 100'000},
      {"motor_radius_mm", geometry.motor_radius_mm, 0.001, 1000},
      {"probe_radius_mm", geometry.probe_radius_mm, 0, 1000},
      {"line_pitch_deg", geometry.polar() ? geometry.line_pitch_deg : 1, 0.001, 10},
      {"sector.half_angle_deg", geometry.sector.half_angle_deg, 0, 89},
      {"sector.reach_mm", geometry.sector.reach_mm, 0, 10'000},
  };
  for (const Bound& bound : bounds) {
    // Negated, so that a NaN fails too.
    if (!(bound.value >= bound.minimum && bound.value <= bound.maximum)) {
      return Error{ErrorCode::kInvalidArgument,
                   fmt::format("the fan geometry's {} is {}, expected {} to {}", bound.name, bound.value,
                               bound.minimum, bound.maximum)};
    }
  }
  if (geometry.polar()) {
    const double widest_deg =
        geometry.line_pitch_deg * std::max(geometry.face_column, geometry.columns - 1 - geometry.face_column);
    if (widest_deg > kWidestLineDeg) {
      return Error{ErrorCode::kInvalidArgument,
                   fmt::format("the outermost scan line stands at {} deg, expected at most {}", widest_deg,
                               kWidestLineDeg)};
    }
    const double first_mm = geometry.probe_radius_mm - geometry.face_row * geometry.pixel_height_mm;
    if (first_mm < 0) {
      return Error{
          ErrorCode::kInvalidArgument,
          fmt::format("the first sample lies {} mm from the apex of the scan lines, expected 0 or more",
                      first_mm)};
    }
  }
  if ((geometry.zero_is_unscanned || geometry.unknown_beams) && geometry.kind != FrameKind::kCartesian) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("the fan geometry's {} is set for {}, expected cartesian frames",
                             geometry.zero_is_unscanned ? "zero_is_unscanned" : "unknown_beams",
                             kFrameKindNames[static_cast<std::size_t>(geometry.kind)])};
  }
  if (!(geometry.depth_mm() > 0)) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("the fan geometry's face_row {} lies below the last row {}, expected a frame "
                             "that reaches into the body",
                             geometry.face_row, geometry.rows - 1)};
  }
  return {};
}

}  // namespace fanlight
