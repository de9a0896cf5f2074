// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "proto/model/fan_geometry.hpp"

namespace fanlight::test {

/// The region of space that a sweep scans.
struct ScannedFan {
  FanGeometry geometry;
  double first_angle_rad = 0;
  double last_angle_rad = 0;

  /// Whether a point of the transducer frame, mm, lies in the region.
  bool holds(const glm::dvec3& at) const {
    const FanCoordinate fan = geometry.fan_coordinate(at.y, at.z);
    if (fan.angle_rad < first_angle_rad || fan.angle_rad > last_angle_rad) return false;
    const FramePlace place = geometry.frame_place({at.x, fan.depth_mm});
    return place.column >= 0 && place.column <= geometry.columns - 1 && place.row >= 0 &&
           place.row <= geometry.rows - 1 && in_sector(at.x, fan.depth_mm + geometry.probe_radius_mm);
  }

  /// Whether a ball lies in the region. Tests its centre and 26 points of its surface.
  bool holds_ball(const glm::dvec3& centre, double radius_mm) const {
    for (int sample = 0; sample < 27; ++sample) {
      const glm::dvec3 direction(sample % 3 - 1, sample / 3 % 3 - 1, sample / 9 - 1);
      const double length = std::max(glm::length(direction), 1.0);
      if (!holds(centre + radius_mm / length * direction)) return false;
    }
    return true;
  }

 private:
  bool in_sector(double x_mm, double from_apex_mm) const {
    const FanGeometry::Sector& sector = geometry.sector;
    if (sector.half_angle_deg == 0) return true;
    const double margin_mm = std::max(geometry.pixel_width_mm, geometry.pixel_height_mm);
    const double reach_mm = std::hypot(x_mm, from_apex_mm);
    return std::abs(x_mm) + margin_mm <= from_apex_mm * std::tan(radians(sector.half_angle_deg)) &&
           reach_mm >= geometry.probe_radius_mm + margin_mm &&
           (sector.reach_mm == 0 || reach_mm <= sector.reach_mm - margin_mm);
  }
};

}  // namespace fanlight::test
