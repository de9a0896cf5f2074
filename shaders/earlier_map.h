// SPDX-License-Identifier: Apache-2.0
// Places in depth maps, and the earlier depth map between its pixels. The includer has included
// steady_parameters.h and light_parameters.h, and declared earlier_map[] where it reads it.
#ifndef FANLIGHT_SHADERS_EARLIER_MAP_H
#define FANLIGHT_SHADERS_EARLIER_MAP_H

// Depths that differ by more are of two surfaces, or noise that no mean should take, mm: next to each other,
// and of cells next to each other.
const float kMostApart = 2.5;
const float kMostCellsApart = 8.0;

float scale_at(MapView view, float depth) {
  return view.scale_at_0 + view.scale_per_mm * depth;
}

// The place of a pixel's surface in the frame of its map.
vec3 place_at(MapView view, vec2 pixel, float depth) {
  return vec3((pixel - view.middle) * scale_at(view, depth), depth);
}

// The pixel that shows a place. Far outside where the place lies beside or behind the eye.
vec2 pixel_at(MapView view, vec3 place) {
  return view.middle + place.xy / max(scale_at(view, place.z), 1e-4);
}

bool is_in_view(MapView view, vec2 pixel) {
  return pixel.x >= float(view.left) - 0.5 && pixel.y >= float(view.top) - 0.5 &&
         pixel.x <= float(view.right) + 0.5 && pixel.y <= float(view.bottom) + 0.5;
}

// The middle of a cell, as a pixel.
vec2 middle_of_cell(MapView view, ivec2 cell) {
  return vec2(view.left, view.top) + (vec2(cell) + 0.5) * float(view.cell_side) - 0.5;
}

// A pixel's column and row among the middles of cells.
vec2 cells_at(MapView view, vec2 pixel) {
  return (pixel - vec2(view.left, view.top) + 0.5) / float(view.cell_side) - 0.5;
}

// How a cell samples its pixels: this number of rows and columns, evenly spaced, so that large pictures cost
// no more than small ones.
int samples_across(MapView view) {
  return min(view.cell_side, 8);
}

#ifdef FANLIGHT_READS_EARLIER_MAP
// The depth, mm, and the volumes of the earlier map at a place between its pixels. Depth FANLIGHT_NO_SURFACE:
// it shows none. Of the nearest pixel where the four around do not show one surface.
vec2 earlier_at(vec2 pixel) {
  MapView view = steady.earlier;
  ivec2 last = ivec2(view.right, view.bottom);
  ivec2 first = clamp(ivec2(floor(pixel)), ivec2(view.left, view.top), max(last, ivec2(0)));
  ivec2 next = min(first + 1, max(last, ivec2(0)));
  vec2 share = clamp(pixel - vec2(first), 0.0, 1.0);
  uint row = uint(first.y) * view.width;
  uint next_row = uint(next.y) * view.width;
  vec2 upper_left = earlier_map[row + uint(first.x)];
  vec2 upper_right = earlier_map[row + uint(next.x)];
  vec2 lower_left = earlier_map[next_row + uint(first.x)];
  vec2 lower_right = earlier_map[next_row + uint(next.x)];
  float smallest = min(min(upper_left.x, upper_right.x), min(lower_left.x, lower_right.x));
  float largest = max(max(upper_left.x, upper_right.x), max(lower_left.x, lower_right.x));
  bool is_even = smallest >= 0.0 && largest - smallest <= min(lighting.same_surface, kMostApart);
  vec2 between = mix(mix(upper_left, upper_right, share.x), mix(lower_left, lower_right, share.x), share.y);
  vec2 upper = share.x < 0.5 ? upper_left : upper_right;
  vec2 lower = share.x < 0.5 ? lower_left : lower_right;
  vec2 nearest = share.y < 0.5 ? upper : lower;
  vec2 found = is_even ? between : nearest;
  return is_in_view(view, pixel) ? found : vec2(FANLIGHT_NO_SURFACE, 0.0);
}
#endif

#endif
