// SPDX-License-Identifier: Apache-2.0
// Pass 2: the smallest depth of the filtered map, above which shadow rays end (light.comp), and how much of
// what is shown is a guess. One invocation a row.
//
// Reads: smooth_depth, float a pixel, mm; volume_colour, RGBA8 a pixel, whose alpha says how sure the surface
//   is (cast.comp). Both: height x width of the picture.
// Writes: min_depth, the bits of a float, mm, which holds FANLIGHT_MAX_DEPTH before; shown_pixels, those with
//   a surface; guessed_pixels, those of them that are not sure. Both hold 0 before.
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
  uint shown_pixels;
  uint guessed_pixels;
};
layout(binding = FANLIGHT_BINDING_VOLUME_COLOUR, scalar) readonly buffer Colours {
  uint volume_colour[];
};

void main() {
  if (gl_GlobalInvocationID.x >= lighting.height) return;
  uint row_start = gl_GlobalInvocationID.x * lighting.width;
  float smallest = FANLIGHT_MAX_DEPTH;
  uint shown = 0u;
  uint guessed = 0u;
  for (uint x = 0u; x < lighting.width; ++x) {
    float depth = smooth_depth[row_start + x];
    smallest = depth >= 0.0 ? min(smallest, depth) : smallest;
    shown += depth >= 0.0 ? 1u : 0u;
    guessed += depth >= 0.0 && volume_colour[row_start + x] >> 24 < 255u ? 1u : 0u;
  }
  // The bits of floats that are not negative have the order of the floats.
  atomicMin(min_depth, floatBitsToUint(smallest));
  atomicAdd(shown_pixels, shown);
  atomicAdd(guessed_pixels, guessed);
}
