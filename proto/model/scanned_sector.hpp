// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "proto/model/fan_geometry.hpp"

namespace fanlight {

/// Whether the scanner has written this place of a frame: inside the sector, where one is known.
inline bool in_sector(const FanGeometry& geometry, double column, double row) {
  if (geometry.kind != FrameKind::kCartesian || geometry.sector.half_angle_deg == 0) return true;
  const PlanePoint at = geometry.plane_point({column, row});
  const double from_apex_mm = at.depth_mm + geometry.probe_radius_mm;
  const double radius_mm = std::hypot(at.x_mm, from_apex_mm);
  return degrees(std::abs(std::atan2(at.x_mm, from_apex_mm))) <= geometry.sector.half_angle_deg &&
         radius_mm >= geometry.probe_radius_mm &&
         (geometry.sector.reach_mm == 0 || radius_mm <= geometry.sector.reach_mm);
}

/// Distance of a place of a frame from the probe's face along the scan line; negative before the face.
inline double from_face_mm(const FanGeometry& geometry, double column, double row) {
  const double along_mm = (row - geometry.face_row) * geometry.pixel_height_mm;
  if (geometry.kind != FrameKind::kCartesian || geometry.probe_radius_mm == 0) return along_mm;
  const double across_mm = (column - geometry.face_column) * geometry.pixel_width_mm;
  return std::hypot(across_mm, along_mm + geometry.probe_radius_mm) - geometry.probe_radius_mm;
}

}  // namespace fanlight
