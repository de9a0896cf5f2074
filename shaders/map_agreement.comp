// SPDX-License-Identifier: Apache-2.0
// Pass 2, temporal filter, step 4: how much the earlier depth map is worth in each cell
// (renderer/ALGORITHM.md, pass 2). The differences of a cell are noise, or motion. Two figures of a cell's
// neighbourhood tell them apart: the mean square of 3 x 3 cells, and what the best shift of 7 x 7 cells
// explains. What noise gives is their median over the picture, whatever the grain of the speckle; but where
// most of the picture moves, what the roughness of the differences allows: motion is smooth from cell to
// cell, noise is not. One group.
//
// Reads: alignment.differences, alignment.slopes.
// Writes: alignment.figures, each invocation its own; alignment.doubt.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "light_parameters.h"
#include "map_alignment.h"

const int kThreads = 64;
layout(local_size_x = 64) in;

layout(binding = FANLIGHT_BINDING_MAP_ALIGNMENT, scalar) buffer Alignment {
  MapAlignment alignment;
};

// Of halving the range of the logarithms in which a median lies.
const int kRounds = 16;
const float kLeastLog = -16.0;
const float kMostLog = 8.0;
// Cells to either side of the neighbourhood that may have moved.
const int kReach = 3;
// Of the normal equations, so that a flat surface has no shift along it.
const float kDamping = 0.01;
// Figures are motion where they are this many times their median.
const vec2 kChance = vec2(8.0, 6.0);
// No mean is worth this: it starts again.
const float kNothing = 1e3;

// Cells from one to those that it is compared with, for the roughness: beyond the grain of usual speckle.
const int kApart = 2;
// The median of the square of (a cell - the mean of four), for noise of variance 1 and independent cells.
const float kRoughness = 0.455 * 1.25;
// Of noise with that roughness the figures' medians are at most this many variances (renderer/RESULTS.md).
const vec2 kMostByNoise = vec2(3.2, 5.0);

shared vec3 counts[kThreads];
// Limits of the logarithms (base 2) of the medians.
shared vec3 least;
shared vec3 most;

// The weighted sum of squares that the best shift explains.
float explained(vec3 diagonal, vec3 mixed, vec3 side) {
  vec3 own = diagonal + kDamping * diagonal.z;
  float determinant = own.x * (own.y * own.z - mixed.z * mixed.z) -
                      mixed.x * (mixed.x * own.z - mixed.z * mixed.y) +
                      mixed.y * (mixed.x * mixed.z - own.y * mixed.y);
  vec3 solved =
      vec3(side.x * (own.y * own.z - mixed.z * mixed.z) + side.y * (mixed.y * mixed.z - mixed.x * own.z) +
               side.z * (mixed.x * mixed.z - mixed.y * own.y),
           side.x * (mixed.z * mixed.y - mixed.x * own.z) + side.y * (own.x * own.z - mixed.y * mixed.y) +
               side.z * (mixed.x * mixed.y - own.x * mixed.z),
           side.x * (mixed.x * mixed.z - own.y * mixed.y) + side.y * (mixed.y * mixed.x - own.x * mixed.z) +
               side.z * (own.x * own.y - mixed.x * mixed.x));
  return max(dot(side, solved) / determinant, 0.0);
}

int number_of(int cell) {
  int row = cell / steady.now.cells_across;
  return row * FANLIGHT_MAP_CELLS + cell - row * steady.now.cells_across;
}

// The square of the difference between a cell and the mean of four; negative where one of them is unknown.
float roughness_at(ivec2 cell) {
  ivec2 last = ivec2(steady.now.cells_across, steady.now.cells_down) - 1;
  int number = cell.y * FANLIGHT_MAP_CELLS + cell.x;
  bool inside =
      cell.x >= kApart && cell.y >= kApart && cell.x + kApart <= last.x && cell.y + kApart <= last.y;
  int across = inside ? kApart : 0;
  int down = inside ? kApart * FANLIGHT_MAP_CELLS : 0;
  vec2 here = alignment.differences[number];
  vec2 left = alignment.differences[number - across];
  vec2 right = alignment.differences[number + across];
  vec2 above = alignment.differences[number - down];
  vec2 below = alignment.differences[number + down];
  float away = here.x - 0.25 * (left.x + right.x + above.x + below.x);
  bool known = inside && min(min(left.y, right.y), min(above.y, below.y)) > 0.0;
  return known ? here.y * away * away : -1.0;
}

// The two figures and the roughness; negative where the cell does not say anything.
vec3 figures_at(ivec2 cell) {
  ivec2 last = ivec2(steady.now.cells_across, steady.now.cells_down) - 1;
  float squares = 0.0;
  float near_weights = 0.0;
  // Normal equations of a shift that explains the differences: to the right, down, and in depth.
  vec3 diagonal = vec3(0.0);
  vec3 mixed = vec3(0.0);  // right and down, right and depth, down and depth
  vec3 side = vec3(0.0);
  for (int y = max(cell.y - kReach, 0); y <= min(cell.y + kReach, last.y); ++y) {
    for (int x = max(cell.x - kReach, 0); x <= min(cell.x + kReach, last.x); ++x) {
      int number = y * FANLIGHT_MAP_CELLS + x;
      vec2 difference = alignment.differences[number];
      vec2 slope = alignment.slopes[number];
      float weight = difference.y;
      float near_weight = abs(x - cell.x) <= 1 && abs(y - cell.y) <= 1 ? weight : 0.0;
      squares += near_weight * difference.x * difference.x;
      near_weights += near_weight;
      diagonal += weight * vec3(slope * slope, 1.0);
      mixed += weight * vec3(slope.x * slope.y, slope);
      side += weight * difference.x * vec3(slope, 1.0);
    }
  }
  bool known = alignment.differences[cell.y * FANLIGHT_MAP_CELLS + cell.x].y > 0.0;
  return known ? vec3(squares / near_weights, explained(diagonal, mixed, side), roughness_at(cell))
               : vec3(-1.0);
}

// The medians of the figures, to least. kLeastLog where none is known.
void find_medians(int thread, int cells) {
  if (thread == 0) {
    least = vec3(kLeastLog);
    most = vec3(kMostLog);
  }
  barrier();
  for (int round = 0; round < kRounds; ++round) {
    vec3 tried = exp2(0.5 * (least + most));
    vec3 above = vec3(0.0);
    for (int cell = thread; cell < cells; cell += kThreads) {
      vec3 figures = alignment.figures[number_of(cell)];
      above += step(0.0, figures) * (2.0 * step(tried, figures) - 1.0);
    }
    counts[thread] = above;
    barrier();
    if (thread == 0) {
      vec3 total = vec3(0.0);
      for (int each = 0; each < kThreads; ++each) total += counts[each];
      vec3 is_above = step(0.5, total);
      vec3 middle = 0.5 * (least + most);
      least += is_above * (middle - least);
      most += (1.0 - is_above) * (middle - most);
    }
    barrier();
  }
}

void main() {
  int thread = int(gl_LocalInvocationID.x);
  int cells = steady.now.cells_across * steady.now.cells_down;
  for (int cell = thread; cell < cells; cell += kThreads) {
    int row = cell / steady.now.cells_across;
    alignment.figures[number_of(cell)] = figures_at(ivec2(cell - row * steady.now.cells_across, row));
  }
  find_medians(thread, cells);
  vec2 noise = exp2(least.xy);
  bool is_rough = least.z > kLeastLog;
  if (is_rough) noise = min(noise, kMostByNoise * exp2(least.z) / kRoughness);
  for (int cell = thread; cell < cells; cell += kThreads) {
    vec3 figures = alignment.figures[number_of(cell)];
    vec2 excess = max(figures.xy / noise - kChance, 0.0);
    alignment.doubt[number_of(cell)] = figures.x >= 0.0 ? excess.x + excess.y : kNothing;
  }
}
