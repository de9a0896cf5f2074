// SPDX-License-Identifier: Apache-2.0
// What map_totals.comp finds in a filtered depth map.
#ifndef FANLIGHT_SHADERS_MAP_TOTALS_H
#define FANLIGHT_SHADERS_MAP_TOTALS_H
#include "vector_types.h"

FANLIGHT_SHADER_STRUCT(MapTotals) {
  uint min_depth;         // bits of a float, mm; FANLIGHT_MAX_DEPTH without a surface
  uint surface_pixels;    // pixels with a surface
  uint uncertain_pixels;  // of these, those whose certainty is below 1, and those of filled holes
}
FANLIGHT_SHADER_STRUCT_END

#endif
