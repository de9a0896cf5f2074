// SPDX-License-Identifier: Apache-2.0
// Pass 3: the outlines of surfaces by coverage instead of stairs (renderer/ALGORITHM.md, pass 3).
//
// Reads: lit; smooth_depth, float a pixel, mm; cleanup_tiles, uint a tile. Writes: diffused. Both pictures:
// four half floats a pixel (lit_picture.h), height x width of the picture.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_control_flow_attributes : require
#include "bindings.h"
#include "light_parameters.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = FANLIGHT_BINDING_LIT, scalar) readonly buffer Lit {
  uvec2 lit[];
};
layout(binding = FANLIGHT_BINDING_DIFFUSED, scalar) writeonly buffer Diffused {
  uvec2 diffused[];
};
layout(binding = FANLIGHT_BINDING_CLEANUP_TILES, scalar) readonly buffer CleanupTiles {
  uint cleanup_tiles[];
};
#include "filtered_map.h"
#include "lit_picture.h"
#include "tiles.h"

vec3 lit_at(ivec2 pixel) {
  return unpacked(lit[index_of(pixel)]);
}

bool may_have_outline(ivec2 pixel) {
  uvec2 tile = uvec2(pixel) / kTile;
  return cleanup_tiles[tile.y * tiles_of(uvec2(lighting.width, lighting.height)).x + tile.x] != 0u;
}
#include "outline_colour.h"

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (pixel.x >= int(lighting.width) || pixel.y >= int(lighting.height)) return;
  uvec2 kept = lit[index_of(pixel)];
  vec4 outlined = outlined_colour(pixel);
  diffused[index_of(pixel)] = outlined.w > 0.0 ? packed(outlined.rgb) : kept;
}
