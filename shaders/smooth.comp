// SPDX-License-Identifier: Apache-2.0
// Pass 2, Gaussian or edge-preserving filter of the depth map (renderer/ALGORITHM.md, pass 2): along rows,
// then along columns. Each fits a weighted line to the depths of the window and takes its value in the
// middle. Inside a surface this is the weighted mean. At the border of a surface, where all neighbours lie
// on one side, it does not move the border towards them, as a mean does. Depths are relative to the middle
// pixel, so that sums lose no precision. Edge-preserving: the weights fall with the difference in depth
// (Tukey's biweight).
//
// Reads: filled, float a pixel, mm, or row_depths of the first half; weights, uint a pixel.
// Writes: row_depths, vec2 a pixel, mm and unused, so that a pixel's place in memory is the same in the lit
//   picture, which lies there later; then smooth_depth, float a pixel, mm. Maps: height x width of the
//   picture.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "light_parameters.h"

layout(local_size_x = 8, local_size_y = 8) in;

// false: rows, filled to row_depths. true: columns, row_depths to smooth_depth.
layout(constant_id = 0) const bool kColumns = false;
// Edge-preserving: depths that differ by `same_surface` or more have no weight.
layout(constant_id = 1) const bool kKeepsEdges = false;

layout(binding = FANLIGHT_BINDING_FILLED, scalar) readonly buffer Filled {
  float filled[];
};
layout(binding = FANLIGHT_BINDING_WEIGHTS, scalar) readonly buffer Weights {
  uint weights[];
};
layout(binding = FANLIGHT_BINDING_ROW_SUMS, scalar) buffer RowSums {
  vec2 row_depths[];
};
layout(binding = FANLIGHT_BINDING_SMOOTH_DEPTH, scalar) writeonly buffer Smooth {
  float smooth_depth[];
};
#include "surface_map.h"

// A line is fitted only where the variance of distances exceeds this fraction of their mean square. Else the
// mean is taken.
const float kMinSpread = 0.02;

float depth_at(uint index) {
  return kColumns ? row_depths[index].x : filled[index];
}

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (pixel.x >= int(lighting.width) || pixel.y >= int(lighting.height)) return;
  uint index = index_of(pixel);
  // By component: for a choice between two vectors by a specialisation constant, Mesa 22.3 uses the first
  // component for all.
  ivec2 axis = ivec2(kColumns ? 0 : 1, kColumns ? 1 : 0);
  int position = kColumns ? pixel.y : pixel.x;
  int first = max(position - lighting.filter_radius, 0);
  int last = min(position + lighting.filter_radius, int(kColumns ? lighting.height : lighting.width) - 1);
  float middle = depth_at(index);

  // Sums of weight, weight * distance and weight * distance^2; of weight * depth and weight * distance *
  // depth.
  vec3 spread = vec3(0.0);
  vec2 depths = vec2(0.0);
  bool has_surface = weights[index] > 0u;
  // A loop, not an `if`: where no lane has a surface, nothing is read.
  for (int at = first; at <= (has_surface ? last : -1); ++at) {
    uint neighbour = index_of(pixel + (at - position) * axis);
    float distance = float(at - position);
    float difference = depth_at(neighbour) - middle;
    float ratio = difference / lighting.same_surface;
    float similarity = max(1.0 - ratio * ratio, 0.0);
    float weight = float(weights[neighbour]) * exp(-distance * distance * lighting.filter_fall) *
                   (kKeepsEdges ? similarity * similarity : 1.0);
    spread += weight * vec3(1.0, distance, distance * distance);
    depths += weight > 0.0 ? weight * difference * vec2(1.0, distance) : vec2(0.0);
  }
  float determinant = spread.x * spread.z - spread.y * spread.y;
  bool is_line = determinant > kMinSpread * spread.x * spread.z;
  float line = (spread.z * depths.x - spread.y * depths.y) / determinant;
  float fitted = middle + (is_line ? line : depths.x / max(spread.x, 1e-30));
  if (kColumns) {
    smooth_depth[index] = has_surface ? fitted : FANLIGHT_NO_SURFACE;
  } else {
    row_depths[index].x = fitted;
  }
}
