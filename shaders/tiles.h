// The picture's tiles, numbered along their rows.
#ifndef FANLIGHT_SHADERS_TILES_H
#define FANLIGHT_SHADERS_TILES_H

const uint kTile = 8u;

uvec2 tiles_of(uvec2 size) { return (size + kTile - 1u) / kTile; }

uint tile_of(uvec2 pixel, uint width) {
  uvec2 tile = pixel / kTile;
  return tile.y * tiles_of(uvec2(width)).x + tile.x;
}

#endif
