// SPDX-License-Identifier: Apache-2.0
// Pass 2: the range of depths in each tile of 8 x 8 pixels, for cleanup_tiles.comp. One invocation a tile.
//
// Reads: steady_map, vec2 a pixel: depth in mm, and volumes; height x width of the picture.
// Writes: tile_depth_ranges, vec2 a tile, mm: the smallest depth, negative if a pixel has no surface; the
//   largest, negative if no pixel has one.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "light_parameters.h"

layout(local_size_x = 8) in;

layout(binding = FANLIGHT_BINDING_STEADY_MAP, scalar) readonly buffer SteadyMap {
  vec2 steady_map[];
};
layout(binding = FANLIGHT_BINDING_TILE_DEPTH_RANGES, scalar) writeonly buffer TileDepthRanges {
  vec2 tile_depth_ranges[];
};
#include "tiles.h"

void main() {
  uint tile = gl_GlobalInvocationID.x;
  uvec2 tiles = tiles_of(uvec2(lighting.width, lighting.height));
  if (tile >= tiles.x * tiles.y) return;
  uvec2 first = kTile * uvec2(tile % tiles.x, tile / tiles.x);
  uvec2 last = uvec2(lighting.width, lighting.height) - 1u;
  float smallest = FANLIGHT_MAX_DEPTH;
  float largest = FANLIGHT_NO_SURFACE;
  for (uint y = 0u; y < kTile; ++y) {
    for (uint x = 0u; x < kTile; ++x) {
      uvec2 pixel = min(first + uvec2(x, y), last);
      float depth = steady_map[pixel.y * lighting.width + pixel.x].x;
      smallest = min(smallest, depth);
      largest = max(largest, depth);
    }
  }
  tile_depth_ranges[tile] = vec2(smallest, largest);
}
