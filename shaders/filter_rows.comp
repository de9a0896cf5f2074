// Pass 2, first half of the moving average over the depth map: along rows, one row an invocation, as a
// running sum, so that the cost does not grow with the window.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "light_parameters.h"

layout(local_size_x = 8) in;

layout(binding = FANLIGHT_BINDING_LIGHT_PARAMETERS, scalar) uniform Parameters { LightParameters lighting; };
layout(binding = FANLIGHT_BINDING_DEPTH, scalar) readonly buffer DepthMap { float depth[]; };
layout(binding = FANLIGHT_BINDING_ROW_SUMS, scalar) writeonly buffer RowSums { vec2 row_sums[]; };

// Depth and number of the surface at a place in the row; nothing outside it.
vec2 surface_at(uint row_start, int x) {
  bool inside = x >= 0 && x < int(lighting.width);
  float value = depth[row_start + uint(clamp(x, 0, int(lighting.width) - 1))];
  return inside && value >= 0.0 ? vec2(value, 1.0) : vec2(0.0);
}

void main() {
  if (gl_GlobalInvocationID.x >= lighting.height) return;
  uint row_start = gl_GlobalInvocationID.x * lighting.width;
  int radius = lighting.filter_radius;

  vec2 sum = vec2(0.0);
  for (int x = 0; x < radius; ++x) sum += surface_at(row_start, x);
  for (int x = 0; x < int(lighting.width); ++x) {
    sum += surface_at(row_start, x + radius);
    row_sums[row_start + uint(x)] = sum;
    sum -= surface_at(row_start, x - radius);
  }
}
