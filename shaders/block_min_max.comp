// SPDX-License-Identifier: Apache-2.0
// Pass 0: the minimum and maximum grey level of each block of a frame, from which empty space is found
// (empty_space.comp; renderer/ALGORITHM.md, pass 1).
//
// Reads: prepared_frames, words of four pixels (frame_words.h).
// Writes: block_min_max, one word (blocks.h) for each block: frame, row of blocks, block.
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
FANLIGHT_WORDS_TO_READ(FANLIGHT_BINDING_PREPARED_FRAMES, PreparedFramesWords, prepared_frames);
layout(binding = FANLIGHT_BINDING_BLOCK_MIN_MAX, scalar) writeonly buffer BlockMinMax {
  uint block_min_max[];
};
#include "blocks.h"
#include "frame_words.h"

const int kWordsAcross = FANLIGHT_BLOCK / 4;

void main() {
  int across = blocks_along(prepare.columns);
  int column = int(gl_GlobalInvocationID.x);
  if (column >= across) return;
  int row = int(gl_WorkGroupID.y);
  int frame = int(prepare.first_frame + gl_WorkGroupID.z);
  uvec4 minimum = uvec4(255u);
  uvec4 maximum = uvec4(0u);
  for (int y = 0; y < FANLIGHT_BLOCK; ++y) {
    int in_frame = min(row * FANLIGHT_BLOCK + y, int(prepare.rows) - 1);
    for (int x = 0; x < kWordsAcross; ++x) {
      int word = min(column * kWordsAcross + x, words_in_row() - 1);
      uvec4 pixels = pixels_of(fetched(prepared_frames, int(word_at(word, in_frame, frame))));
      // The padding after the last column is not part of the frame.
      bvec4 inside = lessThan(columns_of(word), ivec4(prepare.columns));
      minimum = mix(minimum, min(minimum, pixels), inside);
      maximum = mix(maximum, max(maximum, pixels), inside);
    }
  }
  uint index = (uint(frame) * gl_NumWorkGroups.y + uint(row)) * uint(across) + uint(column);
  block_min_max[index] = packed_min_max(min(min(minimum.x, minimum.y), min(minimum.z, minimum.w)),
                                        max(max(maximum.x, maximum.y), max(maximum.z, maximum.w)));
}
