// SPDX-License-Identifier: Apache-2.0
// What the scalpel has cut away (renderer/ALGORITHM.md, pass 1): a byte for each cell of a grid, whose bits
// are its corners, by x, then y, then z; 1 where the corner is cut. The includer has declared the parameters
// as `rays`.
#ifndef FANLIGHT_SHADERS_CUT_MASK_H
#define FANLIGHT_SHADERS_CUT_MASK_H

#include "whole_number.h"

layout(binding = FANLIGHT_BINDING_CUT_CELLS, scalar) readonly buffer CutCells {
  uint cut_cells[];  // four cells each
};

// Whether anything is cut.
bool has_cuts() {
  return rays.cut_columns > 0;
}

// 0 where all around a point is kept, 1 where all is cut; the cut ends at 0.5. Precondition: has_cuts().
float cut_share(vec3 at) {
  vec3 place = (at - rays.cut_lowest) / rays.cut_cell;
  vec3 cells = vec3(rays.cut_columns, rays.cut_rows, rays.cut_layers);
  vec3 cell = clamp(floor(place), vec3(0.0), cells - 1.0);
  vec3 part = clamp(place - cell, vec3(0.0), vec3(1.0));
  int index = (whole(cell.z) * rays.cut_rows + whole(cell.y)) * rays.cut_columns + whole(cell.x);
  uint corners = cut_cells[uint(index) >> 2u] >> (8u * (uint(index) & 3u));
  vec4 near_corners = vec4((uvec4(corners) >> uvec4(0u, 1u, 2u, 3u)) & 1u);
  vec4 far_corners = vec4((uvec4(corners) >> uvec4(4u, 5u, 6u, 7u)) & 1u);
  vec4 in_layer = mix(near_corners, far_corners, part.z);
  vec2 in_row = mix(in_layer.xy, in_layer.zw, part.y);
  return mix(in_row.x, in_row.y, part.x);
}

bool is_cut(vec3 at) {
  return cut_share(at) >= 0.5;
}

#endif
