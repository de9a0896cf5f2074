// What pass 0 is told with each dispatch.
#ifndef FANLIGHT_SHADERS_PREPARE_CONSTANTS_H
#define FANLIGHT_SHADERS_PREPARE_CONSTANTS_H
#include "vector_types.h"

// Where pass 1 gathers (pack.comp): words from one packed row to the next, and packed rows of a frame. No power of two
// times anything, so that what lies below one another does not share a processor's cache sets.
#define FANLIGHT_PACKED_STRIDE(columns) (((columns) + 3u) / 4u * 4u + 16u)
#define FANLIGHT_PACKED_ROWS(rows) (((rows) + 2u) / 3u)

FANLIGHT_SHADER_STRUCT(PrepareConstants) {
  uint columns;
  uint rows;
  uint frames;        // of the volume
  uint first_frame;   // the first one of this dispatch
  uint first_kept;    // the frame whose coefficients are the first that are kept
  int radius_across;  // the window spans 2 r + 1 frames
  float noise;        // guided: deviation of speckle over its mean
}
FANLIGHT_SHADER_STRUCT_END

#endif
