// Pass 2: the tiles in which a pixel may be an island or a hole. Where all pixels as far as a window reaches lie on one
// surface, or none has one, islands.comp and holes.comp have nothing to do.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "light_parameters.h"

layout(local_size_x = 8) in;  // tiles

layout(binding = FANLIGHT_BINDING_TILE_DEPTHS, scalar) readonly buffer Tiles { vec2 tile_depths[]; };
layout(binding = FANLIGHT_BINDING_UNEVEN, scalar) writeonly buffer Uneven { uint uneven[]; };
#include "tiles.h"

void main() {
  uint tile = gl_GlobalInvocationID.x;
  ivec2 tiles = ivec2(tiles_of(uvec2(lighting.width, lighting.height)));
  if (tile >= uint(tiles.x * tiles.y)) return;
  ivec2 here = ivec2(int(tile) % tiles.x, int(tile) / tiles.x);
  int reach = (max(lighting.islands_radius, lighting.holes_radius) + int(kTile) - 1) / int(kTile);
  ivec2 first = max(here - reach, ivec2(0));
  ivec2 last = min(here + reach, tiles - 1);
  float least = FANLIGHT_FARTHEST;
  float greatest = FANLIGHT_NO_SURFACE;
  for (int y = first.y; y <= last.y; ++y) {
    for (int x = first.x; x <= last.x; ++x) {
      vec2 depths = tile_depths[y * tiles.x + x];
      least = min(least, depths.x);
      greatest = max(greatest, depths.y);
    }
  }
  bool one_surface = least >= 0.0 && greatest - least <= lighting.same_surface;
  bool nothing = greatest < 0.0;
  uneven[tile] = one_surface || nothing ? 0u : 1u;
}
