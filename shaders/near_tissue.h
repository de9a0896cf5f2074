// SPDX-License-Identifier: Apache-2.0
// Near tissue that a scene removes (renderer/ALGORITHM.md, pass 1): the depths at which rays start to show
// anything, on a grid of points over the picture, and where it ends in the fan, for the planes.
#ifndef FANLIGHT_SHADERS_NEAR_TISSUE_H
#define FANLIGHT_SHADERS_NEAR_TISSUE_H
#include "vector_types.h"

// Points across the picture, and down.
#define FANLIGHT_RAY_STARTS 33
// Points across a frame, and along the sweep: NearTissue::kAcross and kAround.
#define FANLIGHT_NEAR_ENDS 32

FANLIGHT_SHADER_STRUCT(NearTissueParameters) {
  float start_columns;  // points of ray_start for each pixel
  float start_rows;
  float end_columns;  // points of end_row for each column of a frame
  float end_angles;   // for each rad, from end_first_angle on
  float end_first_angle;
  float row_mm;                                                // of a frame
  float ray_start[FANLIGHT_RAY_STARTS * FANLIGHT_RAY_STARTS];  // mm below the view plane; row by row
  float end_row[FANLIGHT_NEAR_ENDS * FANLIGHT_NEAR_ENDS];      // of a frame; angle by angle
}
FANLIGHT_SHADER_STRUCT_END

#ifndef __cplusplus
layout(binding = FANLIGHT_BINDING_NEAR_TISSUE, scalar) uniform NearTissue {
  NearTissueParameters near;
};

// Linear between the points.
float start_of_ray(vec2 pixel) {
  vec2 at = clamp(pixel * vec2(near.start_columns, near.start_rows), 0.0, float(FANLIGHT_RAY_STARTS - 1));
  ivec2 first = min(ivec2(at), ivec2(FANLIGHT_RAY_STARTS - 2));
  vec2 share = at - vec2(first);
  int upper = first.y * FANLIGHT_RAY_STARTS + first.x;
  int lower = upper + FANLIGHT_RAY_STARTS;
  return mix(mix(near.ray_start[upper], near.ray_start[upper + 1], share.x),
             mix(near.ray_start[lower], near.ray_start[lower + 1], share.x), share.y);
}

// The row at which near tissue ends, at a column of a frame and a sweep angle.
float end_of_near_tissue(float column, float angle) {
  vec2 at = vec2(column * near.end_columns, (angle - near.end_first_angle) * near.end_angles);
  at = clamp(at, 0.0, float(FANLIGHT_NEAR_ENDS - 1));
  ivec2 first = min(ivec2(at), ivec2(FANLIGHT_NEAR_ENDS - 2));
  vec2 share = at - vec2(first);
  int here = first.y * FANLIGHT_NEAR_ENDS + first.x;
  int next = here + FANLIGHT_NEAR_ENDS;
  return mix(mix(near.end_row[here], near.end_row[here + 1], share.x),
             mix(near.end_row[next], near.end_row[next + 1], share.x), share.y);
}
#endif

#endif
