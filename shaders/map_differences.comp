// SPDX-License-Identifier: Apache-2.0
// Pass 2, temporal filter, step 3: how far the surface of the earlier depth map, moved with the body, lies
// from that of this one in each cell (renderer/ALGORITHM.md, pass 2). One invocation a cell.
//
// Reads: depth, float a pixel, mm; earlier_map, vec2 a pixel: depth in mm, and volumes; alignment.
// Writes: alignment.differences, alignment.slopes, alignment.stretch.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "light_parameters.h"
#include "map_alignment.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = FANLIGHT_BINDING_DEPTH, scalar) readonly buffer DepthMap {
  float depth[];
};
layout(binding = FANLIGHT_BINDING_EARLIER_MAP, scalar) readonly buffer EarlierMap {
  vec2 earlier_map[];
};
layout(binding = FANLIGHT_BINDING_MAP_ALIGNMENT, scalar) buffer Alignment {
  MapAlignment alignment;
};
#define FANLIGHT_READS_EARLIER_MAP
#include "earlier_cells.h"
#include "earlier_map.h"

// Of a cell next to a border or a hole.
const float kWeightWithoutSlope = 0.1;
// mm towards the earlier surface for each mm along a ray: with less, the two maps show too little of one
// another.
const float kLeastAlong = 0.3;

vec3 to_earlier(vec3 place) {
  return alignment.origin + place.x * alignment.right + place.y * alignment.down +
         place.z * alignment.forward;
}

// mm along a ray of this map for each mm along one of the earlier map. 0: they hardly meet.
float stretch_at(ivec2 cell, CellSurface surface) {
  MapView view = steady.now;
  vec2 middle = middle_of_cell(view, cell);
  vec2 widening = (middle - view.middle) * view.scale_per_mm;
  vec3 ray = widening.x * alignment.right + widening.y * alignment.down + alignment.forward;
  float along = dot(surface.gradient, ray);
  return surface.found ? (along >= kLeastAlong ? 1.0 / along : 0.0) : 1.0;
}

void main() {
  ivec2 cell = ivec2(gl_GlobalInvocationID.xy);
  MapView view = steady.now;
  bool is_cell = cell.x < view.cells_across && cell.y < view.cells_down && alignment.found != 0u;
  ivec2 first = ivec2(view.left, view.top) + cell * view.cell_side;
  int across = is_cell ? samples_across(view) : 0;
  float shown = 0.0;
  float count = 0.0;
  float sum = 0.0;
  for (int y = 0; y < across; ++y) {
    for (int x = 0; x < across; ++x) {
      ivec2 pixel = first + (2 * ivec2(x, y) + 1) * view.cell_side / (2 * across);
      bool inside = pixel.x <= view.right && pixel.y <= view.bottom;
      float here = depth[inside ? uint(pixel.y) * view.width + uint(pixel.x) : 0u];
      vec3 place = to_earlier(place_at(view, vec2(pixel), here));
      float before = earlier_at(pixel_at(steady.earlier, place)).x;
      float away = place.z - before;
      bool both = inside && here >= 0.0 && before >= 0.0;
      bool near = both && abs(away) <= min(lighting.same_surface, kMostApart);
      shown += both ? 1.0 : 0.0;
      count += near ? 1.0 : 0.0;
      sum += near ? away : 0.0;
    }
  }
  int number = cell.y * FANLIGHT_MAP_CELLS + cell.x;
  float here = alignment.now_cells[number];
  CellSurface surface = cell_surface_at(to_earlier(place_at(view, middle_of_cell(view, cell), here)));
  surface.found = surface.found && here >= 0.0;
  float stretch = stretch_at(cell, surface);
  vec2 slope = surface.found ? -surface.gradient.xy / surface.gradient.z : vec2(0.0);
  bool compares = count >= 4.0 && 2.0 * count >= shown && stretch > 0.0;
  // Noise along a ray grows with the slope.
  float known = surface.found ? 1.0 / (1.0 + dot(slope, slope)) : kWeightWithoutSlope;
  float weight = compares ? known : 0.0;
  alignment.differences[number] = vec2(sum / max(count, 1.0), weight);
  alignment.slopes[number] = slope;
  alignment.stretch[number] = stretch > 0.0 ? stretch : 1.0;
}
