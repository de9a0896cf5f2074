// SPDX-License-Identifier: Apache-2.0
// Pass 2, light under the surface: it leaves the surface around the place where it entered, by a Gaussian of
// the distance, first along rows, then along columns (renderer/ALGORITHM.md, soft light).
//
// Reads: one map of scattered light (soft_light.h). Writes: the other.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "light_parameters.h"

layout(local_size_x = 8, local_size_y = 8) in;

// false: rows, from the second map to the third. true: columns, back to the second.
layout(constant_id = 0) const bool kColumns = false;
layout(constant_id = 1) const bool kPerspective = false;
#include "scattered_light.h"

void main() {
  ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  ivec2 size = soft_size();
  if (any(greaterThanEqual(at, size))) return;
  uint from = kColumns ? 2u : 1u;
  write_soft_values(at, 3u - from, scattered_light(at, from));
}
