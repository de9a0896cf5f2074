// Pass 2: the depth of the surface that is nearest to the viewer, above which a shadow ray may end. A row an invocation.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "light_parameters.h"

layout(local_size_x = 8) in;

layout(binding = FANLIGHT_BINDING_SMOOTH_DEPTH, scalar) readonly buffer Smooth { float smooth_depth[]; };
layout(binding = FANLIGHT_BINDING_NEAREST, scalar) buffer Nearest { uint nearest; };

void main() {
  if (gl_GlobalInvocationID.x >= lighting.height) return;
  uint row_start = gl_GlobalInvocationID.x * lighting.width;
  float least = FANLIGHT_FARTHEST;
  for (uint x = 0u; x < lighting.width; ++x) {
    float depth = smooth_depth[row_start + x];
    least = depth >= 0.0 ? min(least, depth) : least;
  }
  // The bits of floats that are not negative are in their order.
  atomicMin(nearest, floatBitsToUint(least));
}
