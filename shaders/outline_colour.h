// SPDX-License-Identifier: Apache-2.0
// The outlines of surfaces by coverage (renderer/ALGORITHM.md, pass 3). Shared by outline.comp and
// web/outline.frag. The includer has declared the parameters as `lighting`, and
//   float filtered_depth(ivec2 pixel)   of a pixel in the viewport, mm; FANLIGHT_NO_SURFACE
//   vec3 lit_at(ivec2 pixel)            the picture of pass 2
//   bool may_have_outline(ivec2 pixel)  false where all pixels about it are known to lie on one surface
#ifndef FANLIGHT_SHADERS_OUTLINE_COLOUR_H
#define FANLIGHT_SHADERS_OUTLINE_COLOUR_H
#include "surface_map.h"

// Smallest depth of nine pixels of a window: its corners, the middles of its sides, its centre.
// FANLIGHT_MAX_DEPTH where these lie on one surface or have none: no outline is looked for there.
float front_of(ivec4 window, ivec2 pixel, bool looks) {
  float nearest = FANLIGHT_MAX_DEPTH;  // of surfaces
  float smallest = FANLIGHT_MAX_DEPTH;
  float largest = FANLIGHT_NO_SURFACE;
  for (int each = 0; each < (looks ? 9 : 0); ++each) {
    int across = each % 3;
    int down = each / 3;
    int column = across == 0 ? window.x : across == 1 ? pixel.x : window.z;
    int row = down == 0 ? window.y : down == 1 ? pixel.y : window.w;
    float depth = filtered_depth(ivec2(column, row));
    nearest = depth >= 0.0 ? min(nearest, depth) : nearest;
    smallest = min(smallest, depth);
    largest = max(largest, depth);
  }
  bool even = largest < 0.0 || (smallest >= 0.0 && largest - smallest <= lighting.same_surface);
  return even ? FANLIGHT_MAX_DEPTH : nearest;
}

// The picture with the outline of what is nearest about the pixel. How far the pixel lies inside it comes
// from the weighted share of the window that is inside, over the weighted offset towards it: about a straight
// outline both grow with the distance. Light is mixed by its square, which is near to linear. x to z: the
// colour; w: 1 where it differs from the picture of pass 2.
vec4 outlined_colour(ivec2 pixel) {
  bool seen = in_view(pixel) && may_have_outline(pixel);
  ivec4 window = window_about(pixel, lighting.outline_radius);
  ivec2 inner = clamp(pixel, window.xy, window.zw);
  float front = front_of(window, inner, seen);
  bool looks = seen && front < FANLIGHT_MAX_DEPTH;
  float farthest = front + lighting.same_surface;
  float weights = 0.0;
  float inside = 0.0;
  vec2 offsets = vec2(0.0);
  vec2 inside_offsets = vec2(0.0);
  // Loops, not an `if`: where no lane has an outline, nothing is read.
  for (int row = window.y; row <= (looks ? window.w : -1); ++row) {
    for (int column = window.x; column <= window.z; ++column) {
      vec2 offset = vec2(ivec2(column, row) - pixel);
      float depth = filtered_depth(ivec2(column, row));
      float weight = max(1.0 - dot(offset, offset) * lighting.outline_fall, 0.0);
      float part = depth >= 0.0 && depth <= farthest ? weight : 0.0;
      weights += weight;
      inside += part;
      offsets += weight * offset;
      inside_offsets += part * offset;
    }
  }
  float share = inside / max(weights, 1e-6);
  float towards = length(inside_offsets - share * offsets) / max(weights, 1e-6);
  float covered = clamp(0.5 + (share - 0.5) * lighting.outline_scale / max(towards, 1e-6), 0.0, 1.0);
  float depth_here = filtered_depth(inner);
  bool is_inside = depth_here >= 0.0 && depth_here <= farthest;
  // The light of the other side, from the pixels next to this one.
  bool mixes = looks && inside > 0.0 && covered != (is_inside ? 1.0 : 0.0);
  ivec4 next = window_about(pixel, 1);
  vec3 light = vec3(0.0);
  vec3 here = vec3(0.0);
  float lit_pixels = 0.0;
  for (int row = next.y; row <= (mixes ? next.w : -1); ++row) {
    for (int column = next.x; column <= next.z; ++column) {
      float depth = filtered_depth(ivec2(column, row));
      bool other = (depth >= 0.0 && depth <= farthest) != is_inside;
      vec3 lit = lit_at(ivec2(column, row));
      light += other ? lit * lit : vec3(0.0);
      here = row == pixel.y && column == pixel.x ? lit * lit : here;
      lit_pixels += other ? 1.0 : 0.0;
    }
  }
  float own = is_inside ? covered : 1.0 - covered;
  return vec4(sqrt(mix(light / max(lit_pixels, 1.0), here, own)), lit_pixels > 0.0 ? 1.0 : 0.0);
}

#endif
