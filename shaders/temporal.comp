// SPDX-License-Identifier: Apache-2.0
// Pass 2, temporal filter, last step: the mean of each depth and of those that earlier volumes show of the
// same place of the body (renderer/ALGORITHM.md, pass 2). A pixel counts the volumes of its mean, and starts
// again where the body has moved by itself. Or, in a rolling sweep, the blend of the last sweep's surface
// into the new one (renderer/ALGORITHM.md, rolling sweep).
//
// Reads: depth, float a pixel, mm; with another kKind than FANLIGHT_TEMPORAL_ALONE earlier_map, the map of an
//   earlier volume or picture, and alignment.
// Writes: steady_map, vec2 a pixel: depth in mm, and the number of volumes in it, 0 without a surface. Maps:
//   height x width of the picture.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "light_parameters.h"
#include "map_alignment.h"

layout(local_size_x = 8, local_size_y = 8) in;

// FANLIGHT_TEMPORAL_...
layout(constant_id = 0) const int kKind = FANLIGHT_TEMPORAL_ALONE;

layout(binding = FANLIGHT_BINDING_DEPTH, scalar) readonly buffer DepthMap {
  float depth[];
};
layout(binding = FANLIGHT_BINDING_EARLIER_MAP, scalar) readonly buffer EarlierMap {
  vec2 earlier_map[];
};
layout(binding = FANLIGHT_BINDING_STEADY_MAP, scalar) writeonly buffer SteadyMap {
  vec2 steady_map[];
};
layout(binding = FANLIGHT_BINDING_MAP_ALIGNMENT, scalar) readonly buffer Alignment {
  MapAlignment alignment;
};
#include "surface_map.h"
#define FANLIGHT_READS_EARLIER_MAP
#include "earlier_map.h"

vec2 agreement_of(ivec2 cell) {
  int number = cell.y * FANLIGHT_MAP_CELLS + cell.x;
  return vec2(alignment.doubt[number], alignment.stretch[number]);
}

// Doubt and stretch between the middles of cells.
vec2 agreement_at(vec2 pixel) {
  MapView view = steady.now;
  ivec2 last = max(ivec2(view.cells_across, view.cells_down) - 1, ivec2(0));
  vec2 at = clamp(cells_at(view, pixel), vec2(0.0), vec2(last));
  ivec2 first = ivec2(at);
  ivec2 next = min(first + 1, last);
  vec2 share = at - vec2(first);
  vec2 upper = mix(agreement_of(first), agreement_of(ivec2(next.x, first.y)), share.x);
  vec2 lower = mix(agreement_of(ivec2(first.x, next.y)), agreement_of(next), share.x);
  return mix(upper, lower, share.y);
}

// The mean and the number of its volumes.
vec2 averaged(ivec2 pixel, float now) {
  vec3 local = place_at(steady.now, vec2(pixel), now);
  vec3 place =
      alignment.origin + local.x * alignment.right + local.y * alignment.down + local.z * alignment.forward;
  vec2 before = earlier_at(pixel_at(steady.earlier, place));
  vec2 agreement = agreement_at(vec2(pixel));
  float away = place.z - before.x;
  bool same = in_view(pixel) && before.x >= 0.0 && before.y >= 1.0 &&
              abs(away) <= min(lighting.same_surface, kMostApart);
  float known = 1.0 / (1.0 / max(before.y, 1.0) + agreement.x);
  float volumes = same ? clamp(steady.added_volumes + known, 1.0, steady.most_volumes) : 1.0;
  return vec2(now - (1.0 - 1.0 / volumes) * agreement.y * away, volumes);
}

// How much of the last sweep's surface is left at a place, of what the map before has of it.
float left_of_last_sweep(vec3 place) {
  float along = dot(steady.seam.along, place) + steady.seam.along_at_0;
  float across = dot(steady.seam.across, place) + steady.seam.across_at_0;
  float angle = atan(across, along);
  float now = 0.0;
  float before = 0.0;
  for (int frame = 0; frame < steady.seam.frames; ++frame) {
    float near = max(1.0 - abs(angle - steady.seam.angles[frame]) * steady.seam.frames_per_rad, 0.0);
    now += near * steady.seam.shares[frame];
    before += near * steady.seam.shares_before[frame];
  }
  return min(now / max(before, 1e-6), 1.0);
}

// Depths of two sweeps that differ by more are of two surfaces, such as the side of a nose and a cheek, mm.
const float kMostSweepsApart = 5.0;

// The depth between those of the last sweep and of the new one. The less of the former, the farther they lie
// apart.
vec2 blended(ivec2 pixel, float now) {
  vec3 local = place_at(steady.now, vec2(pixel), now);
  vec3 place = steady.origin + local.x * steady.right + local.y * steady.down + local.z * steady.forward;
  bool same_view = steady.seam.same_view != 0;
  float before = same_view ? earlier_map[index_of(pixel)].x : earlier_at(pixel_at(steady.earlier, place)).x;
  float away = (same_view ? now : place.z) - before;
  float ratio = away / min(lighting.same_surface, kMostSweepsApart);
  float similarity = in_view(pixel) && before >= 0.0 ? max(1.0 - ratio * ratio, 0.0) : 0.0;
  return vec2(now - left_of_last_sweep(local) * similarity * away, 1.0);
}

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (pixel.x >= int(lighting.width) || pixel.y >= int(lighting.height)) return;
  uint index = index_of(pixel);
  float now = depth[index];
  vec2 result = vec2(now, now >= 0.0 ? 1.0 : 0.0);
  bool averages = kKind == FANLIGHT_TEMPORAL_STEADY && now >= 0.0 && alignment.found != 0u;
  // A loop, not an `if`: where no lane has a surface, nothing is read.
  for (int once = averages ? 0 : 1; once < 1; ++once) result = averaged(pixel, now);
  bool blends = kKind == FANLIGHT_TEMPORAL_SEAM && now >= 0.0;
  for (int once = blends ? 0 : 1; once < 1; ++once) result = blended(pixel, now);
  steady_map[index] = result;
}
