// SPDX-License-Identifier: Apache-2.0
// Pass 2, moving average of the depth map, step 2: along columns (renderer/ALGORITHM.md, pass 2). One
// invocation a column. Computes the rows from smooth_top to smooth_bottom. A pixel without a surface stays
// without, and does not contribute to its neighbours.
//
// Reads: row_sums, uvec2 a pixel (mean_rows.comp); weights, uint a pixel.
// Writes: smooth_depth, float a pixel, mm. Maps: height x width of the picture.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "light_parameters.h"

layout(local_size_x = 8) in;

layout(binding = FANLIGHT_BINDING_WEIGHTS, scalar) readonly buffer Weights {
  uint weights[];
};
layout(binding = FANLIGHT_BINDING_ROW_SUMS, scalar) readonly buffer RowSums {
  uvec2 row_sums[];
};
layout(binding = FANLIGHT_BINDING_SMOOTH_DEPTH, scalar) writeonly buffer Smooth {
  float smooth_depth[];
};

uvec2 row_sum_at(uint x, int y) {
  bool inside = y >= 0 && y < int(lighting.height);
  uvec2 sum = row_sums[uint(clamp(y, 0, int(lighting.height) - 1)) * lighting.width + x];
  return inside ? sum : uvec2(0u);
}

void main() {
  uint x = gl_GlobalInvocationID.x;
  if (x >= lighting.width) return;
  int radius = lighting.filter_radius;

  uvec2 sum = uvec2(0u);
  int first = lighting.smooth_top;
  for (int y = first - radius; y < first + radius; ++y) sum += row_sum_at(x, y);
  for (int y = first; y < min(lighting.smooth_bottom, int(lighting.height)); ++y) {
    sum += row_sum_at(x, y + radius);
    uint index = uint(y) * lighting.width + x;
    // Where the pixel has a surface, its own weight is part of the sum, so the sum of weights is not 0.
    float mean = lighting.depth_white + float(sum.x) / (lighting.sum_units * float(max(sum.y, 1u)));
    smooth_depth[index] = weights[index] > 0u ? mean : FANLIGHT_NO_SURFACE;
    sum -= row_sum_at(x, y - radius);
  }
}
