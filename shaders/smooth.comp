// Pass 2, one half of the Gaussian or of the edge-preserving filter over the depth map: along rows, then along
// columns. Depths are taken from the middle pixel's, so that a sum loses nothing to rounding.
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

layout(binding = FANLIGHT_BINDING_LIGHT_PARAMETERS, scalar) uniform Parameters { LightParameters lighting; };
layout(binding = FANLIGHT_BINDING_FILLED, scalar) readonly buffer Filled { float filled[]; };
layout(binding = FANLIGHT_BINDING_WEIGHTS, scalar) readonly buffer Weights { uint weights[]; };
// The depth along the row, and its weight.
layout(binding = FANLIGHT_BINDING_ROW_SUMS, scalar) buffer RowSums { vec2 row_means[]; };
layout(binding = FANLIGHT_BINDING_SMOOTH_DEPTH, scalar) writeonly buffer Smooth { float smooth_depth[]; };
#include "surface_map.h"

// Depth and weight of a pixel in this half.
vec2 surface_at(uint index) {
  if (!kColumns) return vec2(filled[index], float(weights[index]));
  // A Gaussian's columns weigh what its rows summed, with or without a surface in the middle.
  return vec2(row_means[index].x, kKeepsEdges ? float(weights[index]) : row_means[index].y);
}

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (pixel.x >= int(lighting.width) || pixel.y >= int(lighting.height)) return;
  uint index = index_of(pixel);
  // By component: Mesa 22.3 takes the choice between two vectors by a constant for its first component alone.
  ivec2 axis = ivec2(kColumns ? 0 : 1, kColumns ? 1 : 0);
  int here_at = kColumns ? pixel.y : pixel.x;
  int first = max(here_at - lighting.filter_radius, 0);
  int last = min(here_at + lighting.filter_radius, int(kColumns ? lighting.height : lighting.width) - 1);
  float middle = surface_at(index).x;

  vec2 sum = vec2(0.0);  // of weighted depths, of weights
  for (int at = first; at <= last; ++at) {
    vec2 there = surface_at(index_of(pixel + (at - here_at) * axis));
    float away = float(at - here_at);
    float off = there.x - middle;
    float share = off / lighting.same_surface;
    float alike = max(1.0 - share * share, 0.0);
    float weight = there.y * exp(-away * away * lighting.filter_fall) * (kKeepsEdges ? alike * alike : 1.0);
    sum += weight > 0.0 ? weight * vec2(off, 1.0) : vec2(0.0);
  }
  float mean = middle + sum.x / max(sum.y, 1e-30);
  if (kColumns) {
    smooth_depth[index] = weights[index] > 0u ? mean : FANLIGHT_NO_SURFACE;
  } else {
    row_means[index] = vec2(mean, sum.y);
  }
}
