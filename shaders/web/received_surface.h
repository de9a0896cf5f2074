// SPDX-License-Identifier: Apache-2.0
// What the shaders of passes 2 and 3 read, in a display by WebGL 2: the maps that the server has sent, or
// that turn.vert has made of them (FANLIGHT_TURNED), as textures. The picture is the part that the surface
// covers. Row 0 of a texture is the top row.
#ifndef FANLIGHT_SHADERS_WEB_RECEIVED_SURFACE_H
#define FANLIGHT_SHADERS_WEB_RECEIVED_SURFACE_H
#include "bindings.h"
#include "light_parameters.h"
#include "surface_map.h"

uniform float nearest;  // smallest depth, mm; FANLIGHT_MAX_DEPTH without a surface

float nearest_depth() {
  return nearest;
}

#ifdef FANLIGHT_TURNED
uniform highp sampler2D turned;  // depth, mm; certainty, 0 to 1

float filtered_depth(ivec2 pixel) {
  float depth = texelFetch(turned, pixel, 0).r;
  return depth < 0.0 ? FANLIGHT_NO_SURFACE : depth;
}
#else
uniform highp usampler2D depths;  // in units of depth_unit; kNothing where there is no surface
uniform float depth_unit;         // mm

const uint kNothing = 65535u;

float filtered_depth(ivec2 pixel) {
  uint units = texelFetch(depths, pixel, 0).r;
  return units == kNothing ? FANLIGHT_NO_SURFACE : float(units) * depth_unit;
}
#endif

#endif
