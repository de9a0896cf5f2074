// SPDX-License-Identifier: Apache-2.0
// Pass 0: the minimum and maximum grey level of each block and of the blocks to the right of and below it,
// in a neighbourhood of FANLIGHT_BLOCKS_IN_BOUND x FANLIGHT_BLOCKS_IN_BOUND blocks. One look-up then bounds
// most boxes of pixels that begin in the block (empty_space.comp; renderer/ALGORITHM.md, pass 1).
//
// Reads: block_min_max.
// Writes: neighbour_min_max. Both: one word (blocks.h) for each block.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "buffer_access.h"
#include "prepare_constants.h"

layout(local_size_x = 64) in;  // x: blocks of a row of blocks; y: rows of blocks; z: frames

layout(push_constant, scalar) uniform Constants {
  PrepareConstants prepare;
};
FANLIGHT_WORDS_TO_READ(FANLIGHT_BINDING_BLOCK_MIN_MAX_TEXELS, BlockMinMaxWords, block_min_max);
layout(binding = FANLIGHT_BINDING_NEIGHBOUR_MIN_MAX, scalar) writeonly buffer NeighbourMinMax {
  uint neighbour_min_max[];
};
#include "blocks.h"

void main() {
  int across = blocks_along(prepare.columns);
  int down = int(gl_NumWorkGroups.y);
  ivec2 block = ivec2(gl_GlobalInvocationID.x, gl_WorkGroupID.y);
  if (block.x >= across) return;
  int frame = int(prepare.first_frame + gl_WorkGroupID.z) * down;
  uint minimum = 255u;
  uint maximum = 0u;
  ivec2 last = min(block + FANLIGHT_BLOCKS_IN_BOUND, ivec2(across, down)) - 1;
  for (int y = block.y; y <= last.y; ++y) {
    for (int x = block.x; x <= last.x; ++x) {
      uint min_max = fetched(block_min_max, (frame + y) * across + x);
      minimum = min(minimum, min_of(min_max));
      maximum = max(maximum, max_of(min_max));
    }
  }
  neighbour_min_max[(frame + block.y) * across + block.x] = packed_min_max(minimum, maximum);
}
