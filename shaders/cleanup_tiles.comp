// SPDX-License-Identifier: Apache-2.0
// Pass 2: finds the tiles in which a pixel may belong to an island or a hole. Where all pixels within reach
// of a window lie on one surface, or none has a surface, islands.comp, holes.comp and outline.comp have
// nothing to do. One invocation a tile.
//
// Reads: tile_depth_ranges, vec2 a tile of 8 x 8 pixels, mm.
// Writes: cleanup_tiles, uint a tile: 1 where islands, holes or outlines may be, else 0.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "light_parameters.h"

layout(local_size_x = 8) in;

layout(binding = FANLIGHT_BINDING_TILE_DEPTH_RANGES, scalar) readonly buffer TileDepthRanges {
  vec2 tile_depth_ranges[];
};
layout(binding = FANLIGHT_BINDING_CLEANUP_TILES, scalar) writeonly buffer CleanupTiles {
  uint cleanup_tiles[];
};
#include "tiles.h"

void main() {
  uint tile = gl_GlobalInvocationID.x;
  ivec2 tiles = ivec2(tiles_of(uvec2(lighting.width, lighting.height)));
  if (tile >= uint(tiles.x * tiles.y)) return;
  ivec2 here = ivec2(int(tile) % tiles.x, int(tile) / tiles.x);
  int reach = (max(lighting.islands_radius, lighting.holes_radius) + int(kTile) - 1) / int(kTile);
  // The windows of outline.comp reach the next tiles.
  reach = max(reach, 1);
  ivec2 first = max(here - reach, ivec2(0));
  ivec2 last = min(here + reach, tiles - 1);
  float smallest = FANLIGHT_MAX_DEPTH;
  float largest = FANLIGHT_NO_SURFACE;
  for (int y = first.y; y <= last.y; ++y) {
    for (int x = first.x; x <= last.x; ++x) {
      vec2 depths = tile_depth_ranges[y * tiles.x + x];
      smallest = min(smallest, depths.x);
      largest = max(largest, depths.y);
    }
  }
  bool one_surface = smallest >= 0.0 && largest - smallest <= lighting.same_surface;
  bool no_surface = largest < 0.0;
  cleanup_tiles[tile] = one_surface || no_surface ? 0u : 1u;
}
