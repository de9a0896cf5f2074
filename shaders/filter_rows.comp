// Pass 2, first half of the moving average over the depth map: along rows, one row an invocation, as a
// running sum, so that the cost does not grow with the window. Sums are whole numbers of 1/1024 mm: what enters a sum
// leaves it exactly, and 31 x 31 depths of 3000 mm stay below 2^32.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "light_parameters.h"

layout(local_size_x = 8) in;

layout(binding = FANLIGHT_BINDING_LIGHT_PARAMETERS, scalar) uniform Parameters { LightParameters lighting; };
layout(binding = FANLIGHT_BINDING_DEPTH, scalar) readonly buffer DepthMap { float depth[]; };
layout(binding = FANLIGHT_BINDING_ROW_SUMS, scalar) writeonly buffer RowSums { uvec2 row_sums[]; };

// Depth and number of the surface at a place in the row; nothing outside it.
uvec2 surface_at(uint row_start, int x) {
  bool inside = x >= 0 && x < int(lighting.width);
  float value = depth[row_start + uint(clamp(x, 0, int(lighting.width) - 1))];
  return inside && value >= 0.0 ? uvec2(uint(value * FANLIGHT_SUM_UNITS_PER_MM + 0.5), 1u) : uvec2(0u);
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
