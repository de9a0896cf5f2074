// What pass 0 is told with each dispatch.
#ifndef FANLIGHT_SHADERS_PREPARE_CONSTANTS_H
#define FANLIGHT_SHADERS_PREPARE_CONSTANTS_H
#include "vector_types.h"

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
