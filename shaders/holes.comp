// SPDX-License-Identifier: Apache-2.0
// Pass 2: fills small holes, and computes the weight of each pixel in the depth filter
// (renderer/ALGORITHM.md, pass 2). A pixel without a surface gets one where at least half of the window
// around it has one: the mean of the depths on the surface of the nearest pixel, weighted by 1 / distance^2.
//
// Reads: cleaned; confidence; cleanup_tiles, uint a tile.
// Writes: filled; weights, uint a pixel: 0 without a surface, 1 in a hole that was filled, else by
//   confidence 1 to FANLIGHT_MAX_WEIGHT, or 1. Maps: depths float a pixel, mm, height x width of the
//   picture.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "light_parameters.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = FANLIGHT_BINDING_CONFIDENCE, scalar) readonly buffer Confidences {
  float confidence[];
};
layout(binding = FANLIGHT_BINDING_CLEANED, scalar) readonly buffer Cleaned {
  float cleaned[];
};
layout(binding = FANLIGHT_BINDING_FILLED, scalar) writeonly buffer Filled {
  float filled[];
};
layout(binding = FANLIGHT_BINDING_WEIGHTS, scalar) writeonly buffer Weights {
  uint weights[];
};
layout(binding = FANLIGHT_BINDING_CLEANUP_TILES, scalar) readonly buffer CleanupTiles {
  uint cleanup_tiles[];
};
#include "surface_map.h"
#include "tiles.h"

// The depth that fills a hole at the pixel, or FANLIGHT_NO_SURFACE.
float filled_depth(ivec2 pixel) {
  ivec4 window = window_about(pixel, lighting.holes_radius);
  ivec2 size = window.zw - window.xy + 1;
  int surfaces = 0;
  int nearest = 1 << 30;  // squared distance
  float reference = FANLIGHT_NO_SURFACE;
  for (int y = window.y; y <= window.w; ++y) {
    for (int x = window.x; x <= window.z; ++x) {
      float there = cleaned[index_of(ivec2(x, y))];
      ivec2 offset = ivec2(x, y) - pixel;
      int distance_squared = offset.x * offset.x + offset.y * offset.y;
      bool nearer = there >= 0.0 && distance_squared < nearest;
      surfaces += there >= 0.0 ? 1 : 0;
      nearest = nearer ? distance_squared : nearest;
      reference = nearer ? there : reference;
    }
  }
  if (2 * surfaces < size.x * size.y) return FANLIGHT_NO_SURFACE;

  float sum = 0.0;
  float weight_sum = 0.0;
  for (int y = window.y; y <= window.w; ++y) {
    for (int x = window.x; x <= window.z; ++x) {
      float there = cleaned[index_of(ivec2(x, y))];
      vec2 offset = vec2(ivec2(x, y) - pixel);
      float weight = same_surface(there, reference) ? 1.0 / max(dot(offset, offset), 1.0) : 0.0;
      sum += weight * (there - reference);
      weight_sum += weight;
    }
  }
  return reference + sum / max(weight_sum, 1e-6);
}

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (pixel.x >= int(lighting.width) || pixel.y >= int(lighting.height)) return;
  uint index = index_of(pixel);
  float here = cleaned[index];
  bool may_be_hole = cleanup_tiles[tile_of(uvec2(pixel), lighting.width)] != 0u;
  bool is_hole = here < 0.0 && may_be_hole && lighting.holes_radius > 0 && in_view(pixel);
  float confidence_weight = clamp(floor(4.0 * confidence[index] + 0.5), 1.0, float(FANLIGHT_MAX_WEIGHT));
  uint weight = here >= 0.0 && lighting.confidence_counts != 0 ? uint(confidence_weight) : 1u;
  // A loop, not an `if`: where no lane is in a hole, nothing is read.
  for (int once = is_hole ? 0 : 1; once < 1; ++once) here = filled_depth(pixel);
  filled[index] = here;
  weights[index] = here >= 0.0 ? weight : 0u;
}
