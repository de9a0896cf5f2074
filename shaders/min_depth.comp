// SPDX-License-Identifier: Apache-2.0
// Pass 2: the smallest depth of the filtered map. Shadow rays end above it (light.comp). One invocation a
// row.
//
// Reads: smooth_depth, float a pixel, mm, height x width of the picture.
// Writes: min_depth, the bits of a float, mm; it holds FANLIGHT_MAX_DEPTH before.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "light_parameters.h"

layout(local_size_x = 8) in;

layout(binding = FANLIGHT_BINDING_SMOOTH_DEPTH, scalar) readonly buffer Smooth {
  float smooth_depth[];
};
layout(binding = FANLIGHT_BINDING_MIN_DEPTH, scalar) buffer MinDepth {
  uint min_depth;
};

void main() {
  if (gl_GlobalInvocationID.x >= lighting.height) return;
  uint row_start = gl_GlobalInvocationID.x * lighting.width;
  float smallest = FANLIGHT_MAX_DEPTH;
  for (uint x = 0u; x < lighting.width; ++x) {
    float depth = smooth_depth[row_start + x];
    smallest = depth >= 0.0 ? min(smallest, depth) : smallest;
  }
  // The bits of floats that are not negative have the order of the floats.
  atomicMin(min_depth, floatBitsToUint(smallest));
}
