// Pass 1's parameters. Lengths in mm, in the transducer frame.
#ifndef FANLIGHT_SHADERS_CAST_PARAMETERS_H
#define FANLIGHT_SHADERS_CAST_PARAMETERS_H
#include "vector_types.h"

#define FANLIGHT_MOST_SLICES 3

// A plane through the volume in a part of the picture.
FANLIGHT_SHADER_STRUCT(Slice) {
  vec3 origin;  // the point that pixel (0, 0) of the picture would show
  vec3 right_step;
  vec3 down_step;
  uint left;  // the part, in pixels
  uint top;
  uint width;
  uint height;
}
FANLIGHT_SHADER_STRUCT_END

FANLIGHT_SHADER_STRUCT(CastParameters) {
  // The ray of pixel (column, row): origin + column * right_step + row * down_step is its point in the view
  // plane; forward + column * right_turn + row * down_turn leads to the point one deeper.
  vec3 origin;
  vec3 right_step;
  vec3 down_step;
  vec3 forward;
  vec3 right_turn;
  vec3 down_turn;
  vec3 right;  // unit vector along the picture's rows

  uint width;  // of the picture
  uint height;
  uint view_left;  // of the viewport; there are no rays outside it
  uint view_top;
  uint view_width;
  uint view_height;
  uint pixel_stride;  // 1 or 2: a ray for so many by so many pixels, through the first of them

  float start;  // depth of the first sample below the view plane
  float end;    // no sample lies deeper
  float eye;    // depth of the eye; nothing before it is seen
  float step;   // distance of samples, along the ray
  uint steps;   // on a ray at most

  // tan(angle / 2) * angle_scale + angle_offset is the place in the angle table, 0 for its first entry.
  float angle_scale;
  float angle_offset;
  float last_angle_entry;

  // The column is lateral * column_scale + column_offset, with x for lateral, or the scan line's angle (rad). The row is
  // along * row_scale + row_offset, with the in-plane depth for along, or the distance from the array. In pixels whose
  // centres lie at whole numbers.
  float column_scale;
  float column_offset;
  float row_scale;
  float row_offset;
  float last_column;
  float last_row;
  float last_frame;    // its number, by ascending angle
  vec3 voxel_scale;    // 1 / (size of the volume texture)
  int packed_stride;   // where the volume is gathered: see FANLIGHT_PACKED_STRIDE
  int packed_rows;
  float probe_radius;  // of the array's curvature

  // What the frames cover: x from left to right, angles from the first frame's to the last's, given as
  // (cos, sin), and distances from the sweep axis (motor_radius behind the probe face) up to farthest.
  float left;
  float right_side;
  vec2 first_angle;
  vec2 last_angle;
  float motor_radius;
  float farthest;

  // The scanned sector of a Cartesian frame: |x| + sector_margin <= (rho + probe_radius) * sector_tangent, and the
  // squared distance of (x, rho) from the sector's apex lies between near and far. The margin keeps the samples
  // clear of pixels that were not scanned.
  float sector_tangent;
  float sector_margin;
  float sector_near_squared;
  float sector_far_squared;

  // Nothing outside is shown: a box, and two planes as normal and distance.
  vec3 crop_lowest;
  vec3 crop_highest;
  vec4 clip1;
  vec4 clip2;

  float threshold;  // of the detector, 0 to 1
  int edge_sign;    // +1 dark to bright, -1 bright to dark, 0 either

  // A tile's rays are cut into segments of 1 << segment_shift samples. Grey levels outside least_seen to greatest_seen,
  // 0 to 1, are transparent.
  uint segment_shift;
  float least_seen;
  float greatest_seen;
  int across;  // a sample reaches so many steps across its ray

  uint first_tile;  // of the band that is cast

  uint slices;  // of slice_planes that are in use
  Slice slice_planes[FANLIGHT_MOST_SLICES];
}
FANLIGHT_SHADER_STRUCT_END

#ifndef __cplusplus
layout(binding = FANLIGHT_BINDING_CAST_PARAMETERS, scalar) uniform Parameters { CastParameters parameters[1]; };
#endif

#endif
