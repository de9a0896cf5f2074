// SPDX-License-Identifier: Apache-2.0
// Pass 2, moving average of the depth map, step 1: along rows (renderer/ALGORITHM.md, pass 2). One
// invocation a row. A running sum makes the cost independent of the window's size. Sums are whole numbers,
// so that subtracting what was added is exact: weights times the depth below the start of the rays, in units
// that keep the sum of a whole window below 2^32. Computes the columns from smooth_left to smooth_right.
//
// Reads: filled, float a pixel, mm; weights, uint a pixel.
// Writes: row_sums, uvec2 a pixel: the sums of weighted depth (1 / sum_units mm) and of weights, over the
//   window in the row. Maps: height x width of the picture.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "light_parameters.h"

layout(local_size_x = 8) in;

layout(binding = FANLIGHT_BINDING_FILLED, scalar) readonly buffer Filled {
  float filled[];
};
layout(binding = FANLIGHT_BINDING_WEIGHTS, scalar) readonly buffer Weights {
  uint weights[];
};
layout(binding = FANLIGHT_BINDING_ROW_SUMS, scalar) writeonly buffer RowSums {
  uvec2 row_sums[];
};

// Weighted depth and weight of a pixel of the row; 0 outside it.
uvec2 weighted_depth_at(uint row_start, int x) {
  bool inside = x >= 0 && x < int(lighting.width);
  uint index = row_start + uint(clamp(x, 0, int(lighting.width) - 1));
  uint weight = inside ? weights[index] : 0u;
  return weight * uvec2(uint(max(filled[index] - lighting.depth_white, 0.0) * lighting.sum_units + 0.5), 1u);
}

void main() {
  if (gl_GlobalInvocationID.x >= lighting.height) return;
  uint row_start = gl_GlobalInvocationID.x * lighting.width;
  int radius = lighting.filter_radius;

  uvec2 sum = uvec2(0u);
  int first = lighting.smooth_left;
  for (int x = first - radius; x < first + radius; ++x) sum += weighted_depth_at(row_start, x);
  for (int x = first; x < min(lighting.smooth_right, int(lighting.width)); ++x) {
    sum += weighted_depth_at(row_start, x + radius);
    row_sums[row_start + uint(x)] = sum;
    sum -= weighted_depth_at(row_start, x - radius);
  }
}
