// SPDX-License-Identifier: Apache-2.0
// The surface of the earlier depth map between the middles of its cells: where it lies, and its slope. The
// includer has declared `alignment`.
#ifndef FANLIGHT_SHADERS_EARLIER_CELLS_H
#define FANLIGHT_SHADERS_EARLIER_CELLS_H
#include "earlier_map.h"

struct CellSurface {
  bool found;
  float depth;    // mm
  vec3 gradient;  // of (depth of a place) - (depth of the surface on the place's ray), in the map's frame
};

// At the ray of a place in the earlier map's frame. Not found outside the map, and where the four cells
// around do not show one surface.
CellSurface cell_surface_at(vec3 place) {
  MapView view = steady.earlier;
  vec2 pixel = pixel_at(view, place);
  vec2 at = cells_at(view, pixel);
  ivec2 most = ivec2(view.cells_across, view.cells_down) - 2;
  ivec2 first = clamp(ivec2(floor(at)), ivec2(0), max(most, ivec2(0)));
  vec2 share = at - vec2(first);
  int number = first.y * FANLIGHT_MAP_CELLS + first.x;
  float upper_left = alignment.earlier_cells[number];
  float upper_right = alignment.earlier_cells[number + 1];
  float lower_left = alignment.earlier_cells[number + FANLIGHT_MAP_CELLS];
  float lower_right = alignment.earlier_cells[number + FANLIGHT_MAP_CELLS + 1];
  float smallest = min(min(upper_left, upper_right), min(lower_left, lower_right));
  float largest = max(max(upper_left, upper_right), max(lower_left, lower_right));

  CellSurface surface;
  bool inside =
      share.x >= 0.0 && share.y >= 0.0 && share.x <= 1.0 && share.y <= 1.0 && most.x >= 0 && most.y >= 0;
  surface.found =
      inside && smallest >= 0.0 && largest - smallest <= min(2.0 * lighting.same_surface, kMostCellsApart);
  surface.depth = mix(mix(upper_left, upper_right, share.x), mix(lower_left, lower_right, share.x), share.y);
  vec2 by_pixel = vec2(mix(upper_right - upper_left, lower_right - lower_left, share.y),
                       mix(lower_left - upper_left, lower_right - upper_right, share.x)) /
                  float(view.cell_side);
  float scale = max(scale_at(view, place.z), 1e-4);
  surface.gradient =
      vec3(-by_pixel / scale, 1.0 + dot(by_pixel, pixel - view.middle) * view.scale_per_mm / scale);
  return surface;
}

#endif
