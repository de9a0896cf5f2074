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

vec3 lit_at(ivec2 pixel) {
  uvec2 inside = min(uvec2(pixel), uvec2(lighting.width, lighting.height) - 1u);
  return unpacked(lit[inside.y * lighting.width + inside.x]);
}
#include "finish_colour.h"

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (pixel.x >= int(lighting.width) || pixel.y >= int(lighting.height)) return;
  finished[uint(pixel.y) * lighting.width + uint(pixel.x)] = packUnorm4x8(vec4(finished_colour(pixel), 1.0));
}
