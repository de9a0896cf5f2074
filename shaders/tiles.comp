// Pass 2: the depths in each tile of 8 x 8 pixels, a tile an invocation. Least: negative where a pixel has no surface.
// Greatest: negative where none has one.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "light_parameters.h"

layout(local_size_x = 8) in;

layout(binding = FANLIGHT_BINDING_STEADY, scalar) readonly buffer Steady { float steady[]; };
layout(binding = FANLIGHT_BINDING_TILE_DEPTHS, scalar) writeonly buffer Tiles { vec2 tile_depths[]; };
#include "tiles.h"

void main() {
  uint tile = gl_GlobalInvocationID.x;
  uvec2 tiles = tiles_of(uvec2(lighting.width, lighting.height));
  if (tile >= tiles.x * tiles.y) return;
  uvec2 first = kTile * uvec2(tile % tiles.x, tile / tiles.x);
  uvec2 last = uvec2(lighting.width, lighting.height) - 1u;
  float least = FANLIGHT_FARTHEST;
  float greatest = FANLIGHT_NO_SURFACE;
  for (uint y = 0u; y < kTile; ++y) {
    for (uint x = 0u; x < kTile; ++x) {
      uvec2 pixel = min(first + uvec2(x, y), last);
      float depth = steady[pixel.y * lighting.width + pixel.x];
      least = min(least, depth);
      greatest = max(greatest, depth);
    }
  }
  tile_depths[tile] = vec2(least, greatest);
}
