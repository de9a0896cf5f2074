// SPDX-License-Identifier: Apache-2.0
// One half of the Gaussian by which light spreads under the surface. Shared by scatter.comp and
// web/scatter.frag. The includer has declared the constants kColumns and kPerspective.
#ifndef FANLIGHT_SHADERS_SCATTERED_LIGHT_H
#define FANLIGHT_SHADERS_SCATTERED_LIGHT_H
#include "soft_light.h"

// Scattered light and depth at a place, the light spread along rows or columns of the map `from`.
vec4 scattered_light(ivec2 at, uint from) {
  ivec2 size = soft_size();
  ivec2 axis = ivec2(kColumns ? 0 : 1, kColumns ? 1 : 0);
  vec4 here = scattered_at(at, from);
  float depth = here.w;
  int position = kColumns ? at.y : at.x;
  int first = max(position - lighting.scatter_radius, 0);
  int last = min(position + lighting.scatter_radius, (kColumns ? size.y : size.x) - 1);
  // Length in the body of a step between two places.
  float scale = kPerspective ? lighting.view_scale_at_0 + lighting.view_scale_per_mm * depth : 1.0;
  float place = 2.0 * lighting.pixel * scale;
  vec3 sum = vec3(0.0);
  float weights = 0.0;
  // A loop, not an `if`: where no lane has a surface, nothing is read.
  for (int each = first; each <= (depth >= 0.0 ? last : -1); ++each) {
    vec4 there = scattered_at(at + (each - position) * axis, from);
    float across = place * float(each - position);
    float below = there.w - depth;
    float weight = there.w >= 0.0 ? exp(-(across * across + below * below) * lighting.scatter_fall) : 0.0;
    sum += weight * there.xyz;
    weights += weight;
  }
  return vec4(weights > 0.0 ? sum / weights : here.xyz, depth);
}

#endif
