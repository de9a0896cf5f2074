// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <vector>

#include "proto/model/fan_geometry.hpp"

namespace fanlight::test {

/// Cartesian frames of 96 x 120 mm in pixels of 1 mm, for volumes that are surveyed.
inline constexpr FanGeometry kSurveyFan{.columns = 96,
                                        .rows = 120,
                                        .pixel_width_mm = 1,
                                        .pixel_height_mm = 1,
                                        .face_column = 47.5,
                                        .face_row = 0,
                                        .motor_radius_mm = 30};

/// 41 frames from -30 to 30 degrees, in rad.
inline std::vector<double> survey_angles() {
  std::vector<double> angles_rad;
  for (int frame = 0; frame < 41; ++frame) angles_rad.push_back(radians(1.5 * frame - 30));
  return angles_rad;
}

/// A noise of the position, -1 to 1.
inline double position_noise(const Point& at) {
  return std::sin(13.7 * at.x_mm + 7.1 * at.y_mm + 3.3 * at.z_mm) * std::sin(5.3 * at.y_mm - 2 * at.x_mm);
}

}  // namespace fanlight::test
