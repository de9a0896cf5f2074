// Pass 1's parameters. Lengths in mm, in the transducer frame.
#ifndef FANLIGHT_SHADERS_CAST_PARAMETERS_H
#define FANLIGHT_SHADERS_CAST_PARAMETERS_H
#include "vector_types.h"

FANLIGHT_SHADER_STRUCT(CastParameters) {
  vec3 origin;      // where the ray of the top left pixel's centre meets the view plane
  vec3 right_step;  // from a pixel to its right neighbour
  vec3 down_step;   // from a pixel to the one below
  vec3 forward;     // direction of the rays, length 1

  uint width;  // of the picture
  uint height;
  uint steps;   // samples on a ray
  float start;  // depth of the first sample below the view plane
  float step;   // distance of samples

  // (z, y) * table_scale + table_offset is the place in the fan table, 0 to 1 in each axis.
  vec2 table_scale;
  vec2 table_offset;

  // x * column_scale + column_offset is the column, rho * row_scale + row_offset the row, in pixels whose
  // centres lie at whole numbers.
  float column_scale;
  float column_offset;
  float row_scale;
  float row_offset;
  float last_row;
  float last_frame;  // its number, by ascending angle
  vec3 voxel_scale;  // 1 / (size of the volume texture)

  // What the frames cover: x from left to right, angles from the first frame's to the last's, given as
  // (cos, sin), and distances from the sweep axis (motor_radius behind the probe face) up to farthest.
  float left;
  float right;
  vec2 first_angle;
  vec2 last_angle;
  float motor_radius;
  float farthest;

  // The scanned sector of a frame: |x| + sector_margin <= (rho + sector_radius) * sector_tangent, and the
  // squared distance of (x, rho) from the sector's apex lies between near and far. The margin, a pixel,
  // keeps the samples clear of pixels that were not scanned.
  float sector_radius;
  float sector_tangent;
  float sector_margin;
  float sector_near_squared;
  float sector_far_squared;

  float threshold;  // of the detector, 0 to 1
  int edge_sign;    // +1 dark to bright, -1 bright to dark, 0 either

  float transparent;   // of the transfer ramp, 0 to 1
  float ramp_scale;    // 1 / (opaque - transparent)
  float step_opacity;  // of one sample at the top of the ramp
}
FANLIGHT_SHADER_STRUCT_END

#endif
