// SPDX-License-Identifier: Apache-2.0
// Pass 3 of one pixel (renderer/ALGORITHM.md, pass 3). Shared by diffuse.comp, finish.comp and web/*.frag.
// The includer has declared the parameters as `lighting`, and
//   vec3 lit_at(ivec2 pixel)   the picture before the step; beyond its border, the border
#ifndef FANLIGHT_SHADERS_FINISH_COLOUR_H
#define FANLIGHT_SHADERS_FINISH_COLOUR_H
#include "lit_picture.h"

// Step size of the diffusion. With four neighbours, steps up to a quarter are stable.
const float kStep = 0.2;

vec3 flow(vec3 from, vec3 to) {
  float step = (brightness(from) - brightness(to)) * lighting.diffusion_scale;
  return (from - to) / (1.0 + step * step);
}

// After one step of the diffusion.
vec3 diffused_colour(ivec2 pixel) {
  vec3 here = lit_at(pixel);
  vec3 flows = flow(lit_at(pixel + ivec2(1, 0)), here) + flow(lit_at(pixel - ivec2(1, 0)), here) +
               flow(lit_at(pixel + ivec2(0, 1)), here) + flow(lit_at(pixel - ivec2(0, 1)), here);
  return here + kStep * flows;
}

// The colour map at the brightness of a colour: linear between points at equal distances.
vec3 mapped(vec3 colour) {
  float position = clamp(brightness(colour), 0.0, 1.0) * float(FANLIGHT_MAP_POINTS - 1);
  int below = min(int(position), FANLIGHT_MAP_POINTS - 2);
  return mix(lighting.map_points[below], lighting.map_points[below + 1], position - float(below));
}

vec3 finished_colour(ivec2 pixel) {
  vec3 here = lit_at(pixel);
  vec3 neighbours = lit_at(pixel + ivec2(1, 0)) + lit_at(pixel + ivec2(0, 1)) + lit_at(pixel + ivec2(1, 1));
  vec3 smoothed = lighting.mean != 0 ? 0.25 * (here + neighbours) : here;
  return lighting.map_colours != 0 ? mapped(smoothed) : smoothed;
}

#endif
