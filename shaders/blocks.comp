// Pass 0: the least and greatest grey level in each block of a frame.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "prepare_constants.h"

layout(local_size_x = 64) in;  // blocks of a row of blocks; y: the row, z: the frame

layout(push_constant, scalar) uniform Constants { PrepareConstants prepare; };
layout(binding = FANLIGHT_BINDING_READY) uniform usamplerBuffer ready;
layout(binding = FANLIGHT_BINDING_BLOCKS, scalar) writeonly buffer Blocks { uint blocks[]; };
#include "blocks.h"
#include "frame_words.h"

const int kWordsAcross = FANLIGHT_BLOCK / 4;

void main() {
  int across = blocks_along(prepare.columns);
  int column = int(gl_GlobalInvocationID.x);
  if (column >= across) return;
  int row = int(gl_WorkGroupID.y);
  int frame = int(prepare.first_frame + gl_WorkGroupID.z);
  uvec4 least = uvec4(255u);
  uvec4 greatest = uvec4(0u);
  for (int y = 0; y < FANLIGHT_BLOCK; ++y) {
    int in_frame = min(row * FANLIGHT_BLOCK + y, int(prepare.rows) - 1);
    for (int x = 0; x < kWordsAcross; ++x) {
      int word = min(column * kWordsAcross + x, words_in_row() - 1);
      uvec4 pixels = pixels_of(texelFetch(ready, int(word_at(word, in_frame, frame))).x);
      // The padding behind the last column is not part of the frame.
      bvec4 inside = lessThan(columns_of(word), ivec4(prepare.columns));
      least = mix(least, min(least, pixels), inside);
      greatest = mix(greatest, max(greatest, pixels), inside);
    }
  }
  uint index = (uint(frame) * gl_NumWorkGroups.y + uint(row)) * uint(across) + uint(column);
  blocks[index] = word_of_bound(min(min(least.x, least.y), min(least.z, least.w)),
                                max(max(greatest.x, greatest.y), max(greatest.z, greatest.w)));
}
