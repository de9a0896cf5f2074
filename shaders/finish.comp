// SPDX-License-Identifier: Apache-2.0
// Pass 3: the mean of each pixel with its right, lower and lower right neighbours, or the picture as it is;
// then the colour map (renderer/ALGORITHM.md, pass 3).
//
// Reads: lit, four half floats a pixel (lit_picture.h).
// Writes: finished, packed RGBA8 a pixel. Both: height x width of the picture.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "light_parameters.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = FANLIGHT_BINDING_LIT, scalar) readonly buffer Lit {
  uvec2 lit[];
};
layout(binding = FANLIGHT_BINDING_FINISHED, scalar) writeonly buffer Finished {
  uint finished[];
};
#include "lit_picture.h"

vec3 lit_at(uvec2 pixel) {
  uvec2 inside = min(pixel, uvec2(lighting.width, lighting.height) - 1u);
  return unpacked(lit[inside.y * lighting.width + inside.x]);
}

// The colour map at the brightness of a colour: linear between points at equal distances.
vec3 mapped(vec3 colour) {
  float position = clamp(brightness(colour), 0.0, 1.0) * float(FANLIGHT_MAP_POINTS - 1);
  int below = min(int(position), FANLIGHT_MAP_POINTS - 2);
  return mix(lighting.map_points[below], lighting.map_points[below + 1], position - float(below));
}

void main() {
  uvec2 pixel = gl_GlobalInvocationID.xy;
  if (pixel.x >= lighting.width || pixel.y >= lighting.height) return;
  vec3 here = lit_at(pixel);
  vec3 neighbours = lit_at(pixel + uvec2(1, 0)) + lit_at(pixel + uvec2(0, 1)) + lit_at(pixel + uvec2(1, 1));
  vec3 smoothed = lighting.mean != 0 ? 0.25 * (here + neighbours) : here;
  vec3 colour = lighting.map_colours != 0 ? mapped(smoothed) : smoothed;
  finished[pixel.y * lighting.width + pixel.x] = packUnorm4x8(vec4(colour, 1.0));
}
