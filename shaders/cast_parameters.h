// SPDX-License-Identifier: Apache-2.0
// Parameters of pass 1 (renderer/ALGORITHM.md, pass 1). Lengths in mm, in the transducer frame.
#ifndef FANLIGHT_SHADERS_CAST_PARAMETERS_H
#define FANLIGHT_SHADERS_CAST_PARAMETERS_H
#include "vector_types.h"

#define FANLIGHT_MAX_SLICES 9
// The window across a ray: points of each ring, and rings at most.
#define FANLIGHT_ACROSS_POINTS 3
#define FANLIGHT_MAX_ACROSS 3

// A plane through the volume, shown in a part of the picture.
FANLIGHT_SHADER_STRUCT(Slice) {
  vec3 origin;  // the point of the plane at pixel (0, 0) of the picture, inside the part or not
  vec3 right_step;
  vec3 down_step;
  uint left;  // the part, pixels
  uint top;
  uint width;
  uint height;
}
FANLIGHT_SHADER_STRUCT_END

FANLIGHT_SHADER_STRUCT(CastParameters) {
  // The ray of pixel (column, row) starts at origin + column * right_step + row * down_step in the view
  // plane. Its point 1 mm deeper is forward + column * right_turn + row * down_turn further on.
  vec3 origin;
  vec3 right_step;
  vec3 down_step;
  vec3 forward;
  vec3 right_turn;
  vec3 down_turn;
  vec3 right;  // unit vector along the picture's rows

  uint width;  // of the picture
  uint height;
  uint view_left;  // the viewport, pixels; there are no rays outside it
  uint view_top;
  uint view_width;
  uint view_height;
  uint pixel_stride;  // 1 or 2: one ray for pixel_stride x pixel_stride pixels, through the first of them

  float start;  // depth of the first sample below the view plane
  float end;    // depth of the last sample at most
  float eye;    // depth of the eye; no sample lies before it
  float step;   // distance between samples, along the ray
  uint steps;   // samples of a ray at most

  // tan(angle / 2) * angle_scale + angle_offset is the position in the angle table, 0 for its first entry.
  float angle_scale;
  float angle_offset;
  float last_angle_entry;

  // The column is lateral * column_scale + column_offset. lateral: x, or the angle of the scan line (rad).
  // The row is along * row_scale + row_offset. along: the depth in the plane, or the distance from the array.
  // Pixel centres lie at whole numbers.
  float column_scale;
  float column_offset;
  float row_scale;
  float row_offset;
  float last_column;
  float last_row;
  float last_frame;    // its index by ascending angle
  vec3 voxel_scale;    // 1 / (size of the volume texture)
  int packed_stride;   // words from one packed row to the next: FANLIGHT_PACKED_STRIDE
  int packed_rows;     // of a frame: FANLIGHT_PACKED_ROWS
  float probe_radius;  // radius of curvature of the array

  // The region of the frames: x from left to right_side, angles from the first frame's to the last frame's,
  // as (cos, sin), and distances from the sweep axis up to farthest. The axis is motor_radius behind the
  // probe face.
  float left;
  float right_side;
  vec2 first_angle;
  vec2 last_angle;
  float motor_radius;
  float frame_angle;  // from one frame to the next, in the mean, rad
  float farthest;

  // The scanned sector of a Cartesian frame: |x| + sector_margin <= (rho + probe_radius) * sector_tangent,
  // and the squared distance of (x, rho) from the apex of the sector lies between near and far. rho: depth
  // below the probe face. The margin keeps samples away from pixels that were not scanned.
  float sector_tangent;
  float sector_margin;
  float sector_near_squared;
  float sector_far_squared;

  // The least share of its certainty that a surface keeps that is seen against the beam: 0, or 1 where the
  // direction of the beams is unknown.
  float least_seen_by_beam;

  // Crop box and clip planes (unit normal, distance). Nothing outside is shown.
  vec3 crop_lowest;
  vec3 crop_highest;
  vec4 clip1;
  vec4 clip2;

  // What is cut away (cut_mask.h): a grid of cubes of side cut_cell. Without columns nothing is cut.
  vec3 cut_lowest;
  float cut_cell;
  int cut_columns;
  int cut_rows;
  int cut_layers;

  float threshold;       // of the edge detector, 0 to 1
  float rise;            // FANLIGHT_PLACE_LEVEL: share of the way from the fluid's echo to the tissue's
  float reach;           // FANLIGHT_PLACE_LEVEL: of the surface behind a slow rise, for each mm of the rise
  float sheet_below;     // FANLIGHT_PLACE_LEVEL: of a thin bright sheet's front, below its peak, 0 to 1
  float least_tissue;    // FANLIGHT_PLACE_LEVEL: what is darker behind an edge is no tissue, 0 to 1
  float least_contrast;  // what differs by less at an edge is no surface, 0 to 1
  // Edges that are looked for: +1 dark to bright, -1 bright to dark, 0 either, as behind a surface of glass.
  int edge_sign;

  // The rays of a tile are divided into segments of 1 << segment_shift samples. Grey levels outside
  // least_seen to greatest_seen, 0 to 1, are transparent.
  uint segment_shift;
  float least_seen;
  float greatest_seen;
  int across;  // rings of the window across a ray; its points lie within 1.25 `across` steps of the ray
  int beside;  // at least `across`: the result of a ray depends on echoes within 1.5 `beside` steps of it

  uint first_tile;  // first tile of the band

  // Planes show slabs: samples across them, an odd number, 1 of a thin plane, and their distance.
  int slab_samples;
  float slab_step;
  int slab_kind;  // FANLIGHT_SLAB_...

  // The window across a ray, in steps to the right and up (points_across()).
  vec2 across_points[FANLIGHT_ACROSS_POINTS * FANLIGHT_MAX_ACROSS];

  uint slices;  // number of slice_planes in use
  Slice slice_planes[FANLIGHT_MAX_SLICES];
}
FANLIGHT_SHADER_STRUCT_END

#ifndef __cplusplus
layout(binding = FANLIGHT_BINDING_CAST_PARAMETERS, scalar) uniform Parameters {
  CastParameters parameters[1];
};
#endif

#endif
