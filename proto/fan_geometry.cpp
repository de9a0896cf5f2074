#include "proto/fan_geometry.hpp"

#include <fmt/format.h>

namespace fanlight {

namespace {

struct Bound {
  const char* name;
  double value;
  double minimum;
  double maximum;
};

}  // namespace

Result<void> check(const FanGeometry& geometry) {
  const Bound bounds[] = {
      {"columns", static_cast<double>(geometry.columns), 2, 4096},
      {"rows", static_cast<double>(geometry.rows), 2, 4096},
      {"pixel_width_mm", geometry.pixel_width_mm, 0.001, 10},
      {"pixel_height_mm", geometry.pixel_height_mm, 0.001, 10},
      {"face_column", geometry.face_column, -100'000, 100'000},
      {"face_row", geometry.face_row, -100'000, 100'000},
      {"motor_radius_mm", geometry.motor_radius_mm, 0.001, 1000},
      {"sector.probe_radius_mm", geometry.sector.probe_radius_mm, 0, 1000},
      {"sector.half_angle_deg", geometry.sector.half_angle_deg, 0, 89},
      {"sector.reach_mm", geometry.sector.reach_mm, 0, 10'000},
  };
  for (const Bound& bound : bounds) {
    // Written so that a NaN fails too.
    if (!(bound.value >= bound.minimum && bound.value <= bound.maximum)) {
      return Error{ErrorCode::kInvalidArgument,
                   fmt::format("the fan geometry's {} is {}, expected {} to {}", bound.name, bound.value,
                               bound.minimum, bound.maximum)};
    }
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
