// SPDX-License-Identifier: Apache-2.0
// Push constants of pass 0, and the layout of packed frames, which the processor writes
// (renderer/volume/frame_preparer.hpp): words of four rows of one column. The last of them is also the first
// of the next word, so a sample's two rows always lie in one word. A trilinear sample then takes four
// gathered words instead of eight gathered bytes, and the packed frames take a third more memory than the
// frames.
#ifndef FANLIGHT_SHADERS_PREPARE_CONSTANTS_H
#define FANLIGHT_SHADERS_PREPARE_CONSTANTS_H
#include "vector_types.h"

// Words from one packed row to the next, and packed rows of a frame. The 16 extra words keep the stride from
// being a large power of two, so that words below each other do not share the processor's cache sets.
#define FANLIGHT_PACKED_STRIDE(columns) (((columns) + 3u) / 4u * 4u + 16u)
#define FANLIGHT_PACKED_ROWS(rows) (((rows) + 2u) / 3u)

FANLIGHT_SHADER_STRUCT(PrepareConstants) {
  uint columns;
  uint rows;
  uint frames;        // of the volume
  uint first_frame;   // of this dispatch
  uint first_kept;    // guided filter: the first frame whose coefficients are in the buffer
  int radius_across;  // the window spans 2 r + 1 frames
  float noise;        // guided filter: standard deviation of speckle over its mean,
  float levels;       // and that of speckle which is added, in grey levels
}
FANLIGHT_SHADER_STRUCT_END

#endif
