// SPDX-License-Identifier: Apache-2.0
// Pass 2, temporal filter: moves each depth towards that of the previous volume, where both show the same
// surface (renderer/ALGORITHM.md, pass 2): now + steady * (before - now). It calms the depth map from volume
// to volume.
//
// Reads: depth; previous_depth, the result for the previous volume.
// Writes: temporal_depth. All: float a pixel, mm, height x width of the picture.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "light_parameters.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = FANLIGHT_BINDING_DEPTH, scalar) readonly buffer DepthMap {
  float depth[];
};
layout(binding = FANLIGHT_BINDING_PREVIOUS_DEPTH, scalar) readonly buffer PreviousDepth {
  float previous_depth[];
};
layout(binding = FANLIGHT_BINDING_TEMPORAL_DEPTH, scalar) writeonly buffer TemporalDepth {
  float temporal_depth[];
};
#include "surface_map.h"

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (pixel.x >= int(lighting.width) || pixel.y >= int(lighting.height)) return;
  uint index = index_of(pixel);
  float now = depth[index];
  float before = previous_depth[index];
  temporal_depth[index] = same_surface(now, before) ? now + lighting.steady * (before - now) : now;
}
