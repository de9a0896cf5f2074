// Pass 0: bounds over each block and the blocks right of and below it in its frame, so that one look-up bounds most boxes of
// pixels that begin in the block.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "prepare_constants.h"

layout(local_size_x = 64) in;  // as in blocks.comp

layout(push_constant, scalar) uniform Constants { PrepareConstants prepare; };
layout(binding = FANLIGHT_BINDING_BLOCK_TEXELS) uniform usamplerBuffer blocks;
layout(binding = FANLIGHT_BINDING_BOUNDS, scalar) writeonly buffer Bounds { uint bounds[]; };
#include "blocks.h"

void main() {
  int across = blocks_along(prepare.columns);
  int down = int(gl_NumWorkGroups.y);
  ivec2 block = ivec2(gl_GlobalInvocationID.x, gl_WorkGroupID.y);
  if (block.x >= across) return;
  int frame = int(prepare.first_frame + gl_WorkGroupID.z) * down;
  uint least = 255u;
  uint greatest = 0u;
  ivec2 last = min(block + FANLIGHT_BLOCKS_IN_BOUND, ivec2(across, down)) - 1;
  for (int y = block.y; y <= last.y; ++y) {
    for (int x = block.x; x <= last.x; ++x) {
      uint bound = texelFetch(blocks, (frame + y) * across + x).x;
      least = min(least, least_of(bound));
      greatest = max(greatest, greatest_of(bound));
    }
  }
  bounds[(frame + block.y) * across + block.x] = word_of_bound(least, greatest);
}
