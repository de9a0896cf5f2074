// SPDX-License-Identifier: Apache-2.0
// Tiles of 8 x 8 pixels of the picture, numbered along the rows of tiles.
#ifndef FANLIGHT_SHADERS_TILES_H
#define FANLIGHT_SHADERS_TILES_H

const uint kTile = 8u;

// Tiles across and down.
uvec2 tiles_of(uvec2 size) {
  return (size + kTile - 1u) / kTile;
}

uint tile_of(uvec2 pixel, uint width) {
  uvec2 tile = pixel / kTile;
  return tile.y * tiles_of(uvec2(width)).x + tile.x;
}

#endif
