// SPDX-License-Identifier: Apache-2.0
// The filtered depth map in its buffer, as surface_light.h reads it.
#ifndef FANLIGHT_SHADERS_FILTERED_MAP_H
#define FANLIGHT_SHADERS_FILTERED_MAP_H
#include "map_totals.h"
#include "surface_map.h"

layout(binding = FANLIGHT_BINDING_SMOOTH_DEPTH, scalar) readonly buffer Smooth {
  float smooth_depth[];
};
layout(binding = FANLIGHT_BINDING_MAP_TOTALS, scalar) readonly buffer Totals {
  MapTotals totals;
};

float filtered_depth(ivec2 pixel) {
  return smooth_depth[index_of(pixel)];
}

float nearest_depth() {
  return uintBitsToFloat(totals.min_depth);
}

#endif
