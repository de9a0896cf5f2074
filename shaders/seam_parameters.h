// SPDX-License-Identifier: Apache-2.0
// Parameters of the seam of a rolling sweep (renderer/ALGORITHM.md, rolling sweep): the frames that are new
// in the map, and how much of the last sweep's surface is left at each. Angles in rad about the sweep axis,
// lengths in mm.
#ifndef FANLIGHT_SHADERS_SEAM_PARAMETERS_H
#define FANLIGHT_SHADERS_SEAM_PARAMETERS_H
#include "vector_types.h"

#define FANLIGHT_MOST_SEAM_FRAMES 16

FANLIGHT_SHADER_STRUCT(SeamParameters) {
  // From a place in the frame of the map to its distances from the sweep axis: along the middle of the sweep,
  // and across it.
  vec3 along;
  vec3 across;
  float along_at_0;
  float across_at_0;
  float frames_per_rad;
  int frames;     // of the arrays below; newest first
  int same_view;  // 1: the pixels of the map before show the same places
  float angles[FANLIGHT_MOST_SEAM_FRAMES];
  float shares[FANLIGHT_MOST_SEAM_FRAMES];         // of the last sweep's surface, 0 to 1
  float shares_before[FANLIGHT_MOST_SEAM_FRAMES];  // the same in the map before
}
FANLIGHT_SHADER_STRUCT_END

#endif
