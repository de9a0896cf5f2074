// Pass 2, one half of the Gaussian or of the edge-preserving filter over the depth map: along rows, then along
// columns. Each fits a line to the window's depths, weighted by distance, and takes its height in the middle: inside a
// surface that is the weighted mean, and at its rim, where all neighbours lie on one side, it does not pull the rim
// towards them. Depths are taken from the middle pixel's, so that a sum loses nothing to rounding.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "light_parameters.h"

layout(local_size_x = 8, local_size_y = 8) in;

// Off: rows, from the filled depth map. On: columns, from what the rows left.
layout(constant_id = 0) const bool kColumns = false;
// Depths further off than a step of a surface count nothing, those near it less (Tukey's biweight).
layout(constant_id = 1) const bool kKeepsEdges = false;

layout(binding = FANLIGHT_BINDING_FILLED, scalar) readonly buffer Filled { float filled[]; };
layout(binding = FANLIGHT_BINDING_WEIGHTS, scalar) readonly buffer Weights { uint weights[]; };
layout(binding = FANLIGHT_BINDING_ROW_SUMS, scalar) buffer RowSums { float row_depths[]; };
layout(binding = FANLIGHT_BINDING_SMOOTH_DEPTH, scalar) writeonly buffer Smooth { float smooth_depth[]; };
#include "surface_map.h"

// The least that a window must be spread for a line, as a share of its mean square distance.
const float kLeastSpread = 0.02;

float depth_at(uint index) { return kColumns ? row_depths[index] : filled[index]; }

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (pixel.x >= int(lighting.width) || pixel.y >= int(lighting.height)) return;
  uint index = index_of(pixel);
  // By component: Mesa 22.3 takes the choice between two vectors by a constant for its first component alone.
  ivec2 axis = ivec2(kColumns ? 0 : 1, kColumns ? 1 : 0);
  int here_at = kColumns ? pixel.y : pixel.x;
  int first = max(here_at - lighting.filter_radius, 0);
  int last = min(here_at + lighting.filter_radius, int(kColumns ? lighting.height : lighting.width) - 1);
  float middle = depth_at(index);

  // Sums of weight, weight * distance and weight * distance^2; of weight * depth and weight * distance * depth.
  vec3 spread = vec3(0.0);
  vec2 depths = vec2(0.0);
  bool has_surface = weights[index] > 0u;
  // A loop, not a branch: where no pixel of a tile has a surface, nothing is read.
  for (int at = first; at <= (has_surface ? last : -1); ++at) {
    uint there = index_of(pixel + (at - here_at) * axis);
    float away = float(at - here_at);
    float off = depth_at(there) - middle;
    float share = off / lighting.same_surface;
    float alike = max(1.0 - share * share, 0.0);
    float weight = float(weights[there]) * exp(-away * away * lighting.filter_fall) * (kKeepsEdges ? alike * alike : 1.0);
    spread += weight * vec3(1.0, away, away * away);
    depths += weight > 0.0 ? weight * off * vec2(1.0, away) : vec2(0.0);
  }
  float determinant = spread.x * spread.z - spread.y * spread.y;
  bool is_line = determinant > kLeastSpread * spread.x * spread.z;
  float line = (spread.z * depths.x - spread.y * depths.y) / determinant;
  float fitted = middle + (is_line ? line : depths.x / max(spread.x, 1e-30));
  if (kColumns) {
    smooth_depth[index] = has_surface ? fitted : FANLIGHT_NO_SURFACE;
  } else {
    row_depths[index] = fitted;
  }
}
