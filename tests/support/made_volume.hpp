// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>

#include "proto/model/volume.hpp"

namespace fanlight::test {

/// A fan whose volumes are quickly made and cast.
inline constexpr FanGeometry kSmallFan{.columns = 48,
                                       .rows = 48,
                                       .pixel_width_mm = 2,
                                       .pixel_height_mm = 2,
                                       .face_column = 23.5,
                                       .face_row = 0,
                                       .motor_radius_mm = 30};

/// One of finer pixels, for maps that are compared by tenths of a millimetre.
inline constexpr FanGeometry kMapFan{.columns = 96,
                                     .rows = 96,
                                     .pixel_width_mm = 0.8,
                                     .pixel_height_mm = 0.8,
                                     .face_column = 47.5,
                                     .face_row = 0,
                                     .motor_radius_mm = 30};

/// A volume whose frames sample `grey`, a function of a point in the transducer frame; its values are clamped
/// to 0 to 255 and rounded. The frames are added in the order of `angles_rad` and then sorted by angle.
inline Volume made_volume(const FanGeometry& geometry, std::span<const double> angles_rad,
                          const std::function<double(const Point&)>& grey) {
  Volume volume(geometry, static_cast<std::uint32_t>(angles_rad.size()));
  for (std::uint32_t frame = 0; frame < angles_rad.size(); ++frame) {
    const auto pixels = volume.next_frame_pixels();
    for (std::uint32_t row = 0; row < geometry.rows; ++row) {
      for (std::uint32_t column = 0; column < geometry.columns; ++column) {
        const PlanePoint in_plane =
            geometry.plane_point({static_cast<double>(column), static_cast<double>(row)});
        const Point at =
            geometry.point(in_plane.x_mm, {.angle_rad = angles_rad[frame], .depth_mm = in_plane.depth_mm});
        pixels[row * geometry.columns + column] =
            static_cast<std::uint8_t>(std::lround(std::clamp(grey(at), 0.0, 255.0)));
      }
    }
    volume.add_frame({.sequence = frame, .frame_index = frame, .angle_rad = angles_rad[frame]});
  }
  volume.sort_by_angle();
  volume.stamp().volume_id = 1;
  return volume;
}

}  // namespace fanlight::test
