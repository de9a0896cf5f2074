// SPDX-License-Identifier: Apache-2.0
// Pass 3, one step of nonlinear diffusion (Perona and Malik; renderer/ALGORITHM.md, pass 3): a pixel moves
// towards its four neighbours. The flow is divided by 1 + (step in brightness / conductance)^2, so that
// edges remain.
//
// Reads: lit.
// Writes: diffused. Both: four half floats a pixel (lit_picture.h), height x width of the picture.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "light_parameters.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = FANLIGHT_BINDING_LIT, scalar) readonly buffer Lit {
  uvec2 lit[];
};
layout(binding = FANLIGHT_BINDING_DIFFUSED, scalar) writeonly buffer Diffused {
  uvec2 diffused[];
};
#include "lit_picture.h"

// Pixels beyond the border repeat the border.
vec3 lit_at(ivec2 pixel) {
  ivec2 inside = clamp(pixel, ivec2(0), ivec2(lighting.width, lighting.height) - 1);
  return unpacked(lit[uint(inside.y) * lighting.width + uint(inside.x)]);
}

#include "finish_colour.h"

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (pixel.x >= int(lighting.width) || pixel.y >= int(lighting.height)) return;
  diffused[uint(pixel.y) * lighting.width + uint(pixel.x)] = packed(diffused_colour(pixel));
}
