// SPDX-License-Identifier: Apache-2.0
// Blocks of FANLIGHT_BLOCK x FANLIGHT_BLOCK pixels of a frame, and the minimum and maximum grey level (0 to
// 255) of a block in one word.
#ifndef FANLIGHT_SHADERS_BLOCKS_H
#define FANLIGHT_SHADERS_BLOCKS_H

// Blocks that cover a side of a frame.
int blocks_along(uint pixels) {
  return int(pixels + uint(FANLIGHT_BLOCK - 1)) / FANLIGHT_BLOCK;
}

uint packed_min_max(uint least, uint greatest) {
  return least | greatest << 8;
}
uint min_of(uint min_max) {
  return min_max & 0xFFu;
}
uint max_of(uint min_max) {
  return min_max >> 8;
}

#endif
