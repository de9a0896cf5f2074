// SPDX-License-Identifier: Apache-2.0
// Pass 2, soft light: for each 2 x 2 pixels the shadow, the light from everywhere that hollows lose, and the
// light that enters the surface (renderer/ALGORITHM.md, soft light). Of the four pixels, the first that has a
// surface stands for all.
//
// Reads: the parameters; smooth_depth, float a pixel, mm; totals (map_totals.comp).
// Writes: the first two maps of soft_light.h.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_control_flow_attributes : require
#include "bindings.h"
#include "light_parameters.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(constant_id = 0) const bool kPerspective = false;
layout(constant_id = 1) const bool kSoftShadows = true;

#include "filtered_map.h"
#include "soft_surface.h"

void main() {
  ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(at, soft_size()))) return;
  write_soft_light(at, soft_light_of(place_at(at)));
}
