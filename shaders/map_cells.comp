// SPDX-License-Identifier: Apache-2.0
// Pass 2, temporal filter, step 1: the mean depth of each cell of a depth map, by which map_motion.comp finds
// how the body has moved (renderer/ALGORITHM.md, pass 2). A cell has one where almost all of its samples are
// on one surface. One invocation a cell.
//
// Reads: depth, float a pixel, mm; or earlier_map, vec2 a pixel: depth in mm, and volumes.
// Writes: alignment.now_cells, or alignment.earlier_cells.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "light_parameters.h"
#include "map_alignment.h"

layout(local_size_x = 8, local_size_y = 8) in;

// Which map.
layout(constant_id = 0) const bool kEarlier = false;

layout(binding = FANLIGHT_BINDING_DEPTH, scalar) readonly buffer DepthMap {
  float depth[];
};
layout(binding = FANLIGHT_BINDING_EARLIER_MAP, scalar) readonly buffer EarlierMap {
  vec2 earlier_map[];
};
layout(binding = FANLIGHT_BINDING_MAP_ALIGNMENT, scalar) buffer Alignment {
  MapAlignment alignment;
};
#include "earlier_map.h"

// Of the samples of a cell, those on its surface.
const float kLeastShare = 0.85;

void main() {
  ivec2 cell = ivec2(gl_GlobalInvocationID.xy);
  MapView view = steady.now;
  if (kEarlier) view = steady.earlier;
  bool is_cell = cell.x < view.cells_across && cell.y < view.cells_down;
  ivec2 first = ivec2(view.left, view.top) + cell * view.cell_side;
  int across = is_cell ? samples_across(view) : 0;

  // The mean of all, and then of those that are near it.
  float mean = 0.0;
  float share = 0.0;
  for (int round = 0; round < 2; ++round) {
    float sum = 0.0;
    float count = 0.0;
    for (int y = 0; y < across; ++y) {
      for (int x = 0; x < across; ++x) {
        ivec2 pixel = first + (2 * ivec2(x, y) + 1) * view.cell_side / (2 * across);
        bool inside = pixel.x <= view.right && pixel.y <= view.bottom;
        uint index = inside ? uint(pixel.y) * view.width + uint(pixel.x) : 0u;
        float there = kEarlier ? earlier_map[index].x : depth[index];
        bool counts = inside && there >= 0.0 &&
                      (round == 0 || abs(there - mean) <= min(lighting.same_surface, kMostApart));
        sum += counts ? there : 0.0;
        count += counts ? 1.0 : 0.0;
      }
    }
    mean = sum / max(count, 1.0);
    share = count / max(float(across * across), 1.0);
  }
  float found = share >= kLeastShare ? mean : FANLIGHT_NO_SURFACE;
  int number = cell.y * FANLIGHT_MAP_CELLS + cell.x;
  if (kEarlier) {
    alignment.earlier_cells[number] = found;
  } else {
    alignment.now_cells[number] = found;
  }
}
