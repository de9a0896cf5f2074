// SPDX-License-Identifier: Apache-2.0
// Pass 2, light under the surface: it leaves the surface around the place where it entered, by a Gaussian of
// the distance, first along rows, then along columns (renderer/ALGORITHM.md, soft light).
//
// Reads: one map of soft_light.h. Writes: the other; only `scattered` differs.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "light_parameters.h"

layout(local_size_x = 8, local_size_y = 8) in;

// false: rows, from the first map to the second. true: columns, back to the first.
layout(constant_id = 0) const bool kColumns = false;
layout(constant_id = 1) const bool kPerspective = false;
#include "soft_light.h"

void main() {
  ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  ivec2 size = soft_size();
  if (any(greaterThanEqual(at, size))) return;
  uint from = kColumns ? 1u : 0u;
  ivec2 axis = ivec2(kColumns ? 0 : 1, kColumns ? 1 : 0);
  SoftLight here = soft_light_at(at, from);
  int position = kColumns ? at.y : at.x;
  int first = max(position - lighting.scatter_radius, 0);
  int last = min(position + lighting.scatter_radius, (kColumns ? size.y : size.x) - 1);
  // Length in the body of a step between two places.
  float scale = kPerspective ? lighting.view_scale_at_0 + lighting.view_scale_per_mm * here.depth : 1.0;
  float place = 2.0 * lighting.pixel * scale;
  float sum = 0.0;
  float weights = 0.0;
  // A loop, not an `if`: where no lane has a surface, nothing is read.
  for (int each = first; each <= (here.depth >= 0.0 ? last : -1); ++each) {
    SoftLight there = soft_light_at(at + (each - position) * axis, from);
    float across = place * float(each - position);
    float below = there.depth - here.depth;
    float weight = there.depth >= 0.0 ? exp(-(across * across + below * below) * lighting.scatter_fall) : 0.0;
    sum += weight * there.scattered;
    weights += weight;
  }
  here.scattered = weights > 0.0 ? sum / weights : here.scattered;
  write_soft_light(at, 1u - from, here);
}
