// Pass 2: draws the depth map towards that of the last volume, where both show the same surface.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "light_parameters.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = FANLIGHT_BINDING_DEPTH, scalar) readonly buffer DepthMap { float depth[]; };
layout(binding = FANLIGHT_BINDING_PREVIOUS, scalar) readonly buffer Previous { float previous[]; };
layout(binding = FANLIGHT_BINDING_STEADY, scalar) writeonly buffer Steady { float steady[]; };
#include "surface_map.h"

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (pixel.x >= int(lighting.width) || pixel.y >= int(lighting.height)) return;
  uint index = index_of(pixel);
  float now = depth[index];
  float before = previous[index];
  steady[index] = same_surface(now, before) ? now + lighting.steady * (before - now) : now;
}
