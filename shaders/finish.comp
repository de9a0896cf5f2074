// Pass 3: the mean of each pixel with its right, lower and lower right neighbours, or the picture as it is.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "light_parameters.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = FANLIGHT_BINDING_LIGHT_PARAMETERS, scalar) uniform Parameters { LightParameters lighting; };
layout(binding = FANLIGHT_BINDING_LIT, scalar) readonly buffer Lit { uint lit[]; };
layout(binding = FANLIGHT_BINDING_FINISHED, scalar) writeonly buffer Finished { uint finished[]; };

vec4 lit_at(uvec2 pixel) {
  uvec2 inside = min(pixel, uvec2(lighting.width, lighting.height) - 1u);
  return unpackUnorm4x8(lit[inside.y * lighting.width + inside.x]);
}

void main() {
  uvec2 pixel = gl_GlobalInvocationID.xy;
  if (pixel.x >= lighting.width || pixel.y >= lighting.height) return;
  vec4 here = lit_at(pixel);
  vec4 others = lit_at(pixel + uvec2(1, 0)) + lit_at(pixel + uvec2(0, 1)) + lit_at(pixel + uvec2(1, 1));
  vec4 mean = 0.25 * (here + others);
  finished[pixel.y * lighting.width + pixel.x] = packUnorm4x8(lighting.mean != 0 ? mean : here);
}
