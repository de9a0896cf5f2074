// SPDX-License-Identifier: Apache-2.0
// Pass 2: removes islands, surfaces that are too small (renderer/ALGORITHM.md, pass 2). A pixel loses its
// surface where less than a quarter of the window around it lies on the same surface. A quarter is what a
// window at the corner of a large surface has.
//
// Reads: steady_map, vec2 a pixel: depth in mm, and volumes; cleanup_tiles, uint a tile.
// Writes: cleaned, float a pixel, mm. Maps: height x width of the picture.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "light_parameters.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = FANLIGHT_BINDING_STEADY_MAP, scalar) readonly buffer SteadyMap {
  vec2 steady_map[];
};
layout(binding = FANLIGHT_BINDING_CLEANED, scalar) writeonly buffer Cleaned {
  float cleaned[];
};
layout(binding = FANLIGHT_BINDING_CLEANUP_TILES, scalar) readonly buffer CleanupTiles {
  uint cleanup_tiles[];
};
#include "surface_map.h"
#include "tiles.h"

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (pixel.x >= int(lighting.width) || pixel.y >= int(lighting.height)) return;
  float here = steady_map[index_of(pixel)].x;
  ivec4 window = window_about(pixel, lighting.islands_radius);
  ivec2 size = window.zw - window.xy + 1;
  bool may_be_island = here >= 0.0 && cleanup_tiles[tile_of(uvec2(pixel), lighting.width)] != 0u;
  int on_surface = may_be_island ? 0 : size.x * size.y;
  // A loop, not an `if`: where no lane may be an island, nothing is read.
  for (int y = window.y; y <= (may_be_island ? window.w : -1); ++y) {
    for (int x = window.x; x <= window.z; ++x) {
      on_surface += same_surface(here, steady_map[index_of(ivec2(x, y))].x) ? 1 : 0;
    }
  }
  cleaned[index_of(pixel)] = 4 * on_surface >= size.x * size.y ? here : FANLIGHT_NO_SURFACE;
}
