// SPDX-License-Identifier: Apache-2.0
// Pass 2: totals of the filtered map: the smallest depth, above which shadow rays end (surface_light.h), and
// how much has a surface and how much of that is uncertain. One invocation a row.
//
// Reads: smooth_depth, float a pixel, mm; volume_colour, RGBA8 a pixel, with the certainty (certainty.h).
//   steady_map, vec2 a pixel: depth before the other filters, and volumes. All: height x width of the
//   picture.
// Writes: totals (map_totals.h), which hold FANLIGHT_MAX_DEPTH and 0 before.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "certainty.h"
#include "light_parameters.h"
#include "map_totals.h"

layout(local_size_x = 8) in;

layout(binding = FANLIGHT_BINDING_SMOOTH_DEPTH, scalar) readonly buffer Smooth {
  float smooth_depth[];
};
layout(binding = FANLIGHT_BINDING_MAP_TOTALS, scalar) buffer Totals {
  MapTotals totals;
};
layout(binding = FANLIGHT_BINDING_VOLUME_COLOUR, scalar) readonly buffer Colours {
  uint volume_colour[];
};
layout(binding = FANLIGHT_BINDING_STEADY_MAP, scalar) readonly buffer SteadyMap {
  vec2 steady_map[];
};

// A pixel with fewer shows one volume.
const float kLeastVolumes = 1.3;

void main() {
  if (gl_GlobalInvocationID.x >= lighting.height) return;
  uint row_start = gl_GlobalInvocationID.x * lighting.width;
  float smallest = FANLIGHT_MAX_DEPTH;
  uint surface_pixels = 0u;
  uint uncertain_pixels = 0u;
  uint steady_pixels = 0u;
  uint volumes = 0u;
  for (uint x = 0u; x < lighting.width; ++x) {
    float depth = smooth_depth[row_start + x];
    smallest = depth >= 0.0 ? min(smallest, depth) : smallest;
    surface_pixels += depth >= 0.0 ? 1u : 0u;
    uncertain_pixels += depth >= 0.0 && certainty_of(volume_colour[row_start + x]) < 1.0 ? 1u : 0u;
    float averaged = steady_map[row_start + x].y;
    bool is_steady = depth >= 0.0 && averaged >= kLeastVolumes;
    steady_pixels += is_steady ? 1u : 0u;
    volumes += is_steady ? uint(averaged * float(FANLIGHT_VOLUME_UNITS) + 0.5) : 0u;
  }
  // The bits of floats that are not negative have the order of the floats.
  atomicMin(totals.min_depth, floatBitsToUint(smallest));
  atomicAdd(totals.surface_pixels, surface_pixels);
  atomicAdd(totals.uncertain_pixels, uncertain_pixels);
  atomicAdd(totals.steady_pixels, steady_pixels);
  atomicAdd(totals.volumes, volumes);
}
