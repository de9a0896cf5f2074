// SPDX-License-Identifier: Apache-2.0
// Pass 2, temporal filter, step 4: how much the earlier depth map is worth in each cell
// (renderer/ALGORITHM.md, pass 2). The differences of a cell are noise, or motion. Two figures of a cell's
// neighbourhood tell them apart: the mean square of 3 x 3 cells, and what the best shift of 7 x 7 cells
// explains. Half of the cells have no more than noise gives, whatever the grain of the speckle. One group.
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

// Mean squares of cells, mm^2, above which the whole picture moves, and not as one body.
const float kMostNoise = 0.25;

shared float counts[2 * kThreads];
// Logarithms (base 2) of the two medians, and their limits.
shared vec2 least;
shared vec2 most;

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

// The two figures; negative where the cell does not say anything.
vec2 figures_at(ivec2 cell) {
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
  return known ? vec2(squares / near_weights, explained(diagonal, mixed, side)) : vec2(-1.0);
}

// The medians of the figures, to least.
void find_medians(int thread, int cells) {
  if (thread == 0) {
    least = vec2(kLeastLog);
    most = vec2(kMostLog);
  }
  barrier();
  for (int round = 0; round < kRounds; ++round) {
    vec2 tried = exp2(0.5 * (least + most));
    vec2 above = vec2(0.0);
    for (int cell = thread; cell < cells; cell += kThreads) {
      vec2 figures = alignment.figures[number_of(cell)];
      above += figures.x >= 0.0 ? 2.0 * step(tried, figures) - 1.0 : vec2(0.0);
    }
    counts[2 * thread] = above.x;
    counts[2 * thread + 1] = above.y;
    barrier();
    if (thread == 0) {
      vec2 total = vec2(0.0);
      for (int each = 0; each < kThreads; ++each) total += vec2(counts[2 * each], counts[2 * each + 1]);
      vec2 middle = 0.5 * (least + most);
      least.x = total.x > 0.0 ? middle.x : least.x;
      least.y = total.y > 0.0 ? middle.y : least.y;
      most.x = total.x > 0.0 ? most.x : middle.x;
      most.y = total.y > 0.0 ? most.y : middle.y;
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
  vec2 noise = exp2(least);
  noise *= min(kMostNoise / noise.x, 1.0);
  for (int cell = thread; cell < cells; cell += kThreads) {
    vec2 figures = alignment.figures[number_of(cell)];
    vec2 excess = max(figures / noise - kChance, 0.0);
    alignment.doubt[number_of(cell)] = figures.x >= 0.0 ? excess.x + excess.y : kNothing;
  }
}
