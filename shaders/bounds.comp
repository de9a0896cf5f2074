// Pass 0: bounds over each block and the blocks right of and below it in its frame, so that one look-up bounds most boxes of
// pixels that begin in the block.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_control_flow_attributes : require
#include "bindings.h"
#include "prepare_constants.h"

layout(local_size_x = 64) in;  // as in blocks.comp

layout(push_constant, scalar) uniform Constants { PrepareConstants prepare; };
layout(binding = FANLIGHT_BINDING_BLOCKS, scalar) readonly buffer Blocks { uint blocks[]; };
layout(binding = FANLIGHT_BINDING_BOUNDS, scalar) writeonly buffer Bounds { uint bounds[]; };
#include "blocks.h"

// A square of blocks an invocation, so that a block is read three times and not sixteen: an invocation in as many across
// and down has work.
const int kSide = FANLIGHT_BLOCKS_IN_BOUND;
const int kRead = 2 * kSide - 1;

void main() {
  int across = blocks_along(prepare.columns);
  int down = int(gl_NumWorkGroups.y);
  ivec2 corner = ivec2(kSide * int(gl_GlobalInvocationID.x), int(gl_WorkGroupID.y));
  if (corner.x >= across || corner.y % kSide != 0) return;
  int frame = int(prepare.first_frame + gl_WorkGroupID.z) * down;
  uint least[kSide * kSide];
  uint greatest[kSide * kSide];
  [[unroll]] for (int bound = 0; bound < kSide * kSide; ++bound) {
    least[bound] = 255u;
    greatest[bound] = 0u;
  }
  [[unroll]] for (int y = 0; y < kRead; ++y) {
    int row = (frame + min(corner.y + y, down - 1)) * across;
    uint least_read[kRead];
    uint greatest_read[kRead];
    [[unroll]] for (int x = 0; x < kRead; ++x) {
      uint block = blocks[row + min(corner.x + x, across - 1)];
      least_read[x] = least_of(block);
      greatest_read[x] = greatest_of(block);
    }
    [[unroll]] for (int x = 0; x < kSide; ++x) {
      uint least_behind = 255u;
      uint greatest_behind = 0u;
      [[unroll]] for (int behind = 0; behind < kSide; ++behind) {
        least_behind = min(least_behind, least_read[x + behind]);
        greatest_behind = max(greatest_behind, greatest_read[x + behind]);
      }
      [[unroll]] for (int up = max(y - kSide + 1, 0); up <= min(y, kSide - 1); ++up) {
        least[up * kSide + x] = min(least[up * kSide + x], least_behind);
        greatest[up * kSide + x] = max(greatest[up * kSide + x], greatest_behind);
      }
    }
  }
  [[unroll]] for (int y = 0; y < kSide; ++y) {
    [[unroll]] for (int x = 0; x < kSide; ++x) {
      ivec2 block = corner + ivec2(x, y);
      if (block.x >= across || block.y >= down) continue;
      bounds[(frame + block.y) * across + block.x] = word_of_bound(least[y * kSide + x], greatest[y * kSide + x]);
    }
  }
}
