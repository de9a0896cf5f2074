// Pass 2, first half of the moving average over the depth map: along rows, one row an invocation, as a
// running sum, so that the cost does not grow with the window. Sums are whole numbers, so that what enters a sum
// leaves it exactly: weights times the depth below the rays' start in units that keep the whole window below 2^32.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "light_parameters.h"

layout(local_size_x = 8) in;

layout(binding = FANLIGHT_BINDING_FILLED, scalar) readonly buffer Filled { float filled[]; };
layout(binding = FANLIGHT_BINDING_WEIGHTS, scalar) readonly buffer Weights { uint weights[]; };
layout(binding = FANLIGHT_BINDING_ROW_SUMS, scalar) writeonly buffer RowSums { uvec2 row_sums[]; };

// Weighted depth and weight at a place in the row; nothing outside it.
uvec2 surface_at(uint row_start, int x) {
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
  for (int x = 0; x < radius; ++x) sum += surface_at(row_start, x);
  for (int x = 0; x < int(lighting.width); ++x) {
    sum += surface_at(row_start, x + radius);
    row_sums[row_start + uint(x)] = sum;
    sum -= surface_at(row_start, x - radius);
  }
}
