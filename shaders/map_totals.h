// SPDX-License-Identifier: Apache-2.0
// What map_totals.comp finds in a filtered depth map.
#ifndef FANLIGHT_SHADERS_MAP_TOTALS_H
#define FANLIGHT_SHADERS_MAP_TOTALS_H
#include "vector_types.h"

// The largest picture, 3840 x 2160 with 20 volumes a pixel, stays below 2^32.
#define FANLIGHT_VOLUME_UNITS 16

FANLIGHT_SHADER_STRUCT(MapTotals) {
  uint min_depth;         // bits of a float, mm; FANLIGHT_MAX_DEPTH without a surface
  uint surface_pixels;    // pixels with a surface
  uint uncertain_pixels;  // of these, those whose certainty is below 1, and those of filled holes
  uint steady_pixels;     // of the surface, those whose depth is a mean over volumes
  uint volumes;           // sum of their numbers of volumes, in units of 1 / FANLIGHT_VOLUME_UNITS
}
FANLIGHT_SHADER_STRUCT_END

#endif
