// SPDX-License-Identifier: Apache-2.0
// Pass 2, temporal filter, step 2: how the body has moved between the earlier depth map and this one, as a
// rigid body (renderer/ALGORITHM.md, pass 2). Gauss-Newton on the distances from the cells of this map to the
// planes of the earlier one (Chen and Medioni, "Object modelling by registration of multiple range images",
// 1992). Cells whose distance stays large, on something that moves by itself, lose their weight (Tukey's
// biweight, with a smaller limit in each round). One group.
//
// Reads: alignment.now_cells, alignment.earlier_cells.
// Writes: alignment.right, down, forward, origin, found.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_control_flow_attributes : require
#include "bindings.h"
#include "light_parameters.h"
#include "map_alignment.h"

const uint kThreads = 64u;
layout(local_size_x = 64) in;

layout(binding = FANLIGHT_BINDING_MAP_ALIGNMENT, scalar) buffer Alignment {
  MapAlignment alignment;
};
#include "earlier_cells.h"
#include "earlier_map.h"

const int kRounds = 6;
// Distances from which a cell has no weight, mm: by the first rounds more than a few mm are found, by the
// last one what moves by itself counts little.
const float kLimits[kRounds] = {4.0, 3.0, 2.0, 1.2, 0.8, 0.8};
// A turn is measured by the path of what lies so far from the pivot, so that all six unknowns are in mm.
const float kLeverMm = 30.0;
// Keeps what the surface does not determine, such as the turn of a ball, where it was.
const float kDamping = 2e-3;
// Farther than this no body moves from volume to volume: mm, and rad.
const float kMostMm = 8.0;
const float kMostTurn = 0.15;
// Of the cells that both maps show.
const float kLeastShare = 0.3;
const float kLeastCells = 12.0;

const int kUnknowns = 6;
const int kProducts = kUnknowns * (kUnknowns + 1) / 2;
// The upper triangle of the normal matrix, its right side, and the sum of weights and of cells.
const int kSums = kProducts + kUnknowns + 2;

shared float sums[kSums * int(kThreads)];
shared float totals[kSums];
// The frame of `now` in that of `earlier`, of this round; and the motion so far.
shared vec3 right;
shared vec3 down;
shared vec3 forward;
shared vec3 origin;
shared vec3 turned;
shared vec3 moved;

vec3 to_earlier(vec3 place) {
  return origin + place.x * right + place.y * down + place.z * forward;
}

// Adds one cell to the sums of this invocation.
void add_cell(ivec2 cell, float limit, inout float sum[kSums]) {
  float depth = alignment.now_cells[cell.y * FANLIGHT_MAP_CELLS + cell.x];
  vec3 place = to_earlier(place_at(steady.now, middle_of_cell(steady.now, cell), depth));
  CellSurface surface = cell_surface_at(place);
  bool both = depth >= 0.0 && surface.found;
  float steepness = length(surface.gradient);
  float away = (place.z - surface.depth) / steepness;
  vec3 normal = surface.gradient / steepness;
  vec3 lever = cross(place - steady.pivot, normal) / kLeverMm;
  float row[kUnknowns] = {lever.x, lever.y, lever.z, normal.x, normal.y, normal.z};
  float share = clamp(away / limit, -1.0, 1.0);
  float weight = both ? (1.0 - share * share) * (1.0 - share * share) : 0.0;
  int next = 0;
  [[unroll]] for (int first = 0; first < kUnknowns; ++first) {
    [[unroll]] for (int second = first; second < kUnknowns; ++second) {
      sum[next++] += both ? weight * row[first] * row[second] : 0.0;
    }
  }
  [[unroll]] for (int each = 0; each < kUnknowns; ++each) sum[next++] -=
      both ? weight * row[each] * away : 0.0;
  sum[next++] += weight;
  sum[next] += both ? 1.0 : 0.0;
}

// Solves the normal equations by Cholesky's decomposition.
void solve(out float solution[kUnknowns]) {
  float lower[kUnknowns * kUnknowns];
  float trace = 0.0;
  int next = 0;
  [[unroll]] for (int first = 0; first < kUnknowns; ++first) {
    [[unroll]] for (int second = first; second < kUnknowns; ++second) {
      lower[second * kUnknowns + first] = totals[next++];
    }
    trace += lower[first * kUnknowns + first];
  }
  float damping = kDamping * trace / float(kUnknowns) + 1e-6;
  [[unroll]] for (int column = 0; column < kUnknowns; ++column) {
    float square = lower[column * kUnknowns + column] + damping;
    [[unroll]] for (int each = 0; each < column; ++each) {
      square -= lower[column * kUnknowns + each] * lower[column * kUnknowns + each];
    }
    float root = sqrt(max(square, 1e-9));
    lower[column * kUnknowns + column] = root;
    [[unroll]] for (int row = column + 1; row < kUnknowns; ++row) {
      float rest = lower[row * kUnknowns + column];
      [[unroll]] for (int each = 0; each < column; ++each) {
        rest -= lower[row * kUnknowns + each] * lower[column * kUnknowns + each];
      }
      lower[row * kUnknowns + column] = rest / root;
    }
  }
  [[unroll]] for (int row = 0; row < kUnknowns; ++row) {
    float rest = totals[kProducts + row];
    [[unroll]] for (int each = 0; each < row; ++each) rest -= lower[row * kUnknowns + each] * solution[each];
    solution[row] = rest / lower[row * kUnknowns + row];
  }
  [[unroll]] for (int row = kUnknowns - 1; row >= 0; --row) {
    float rest = solution[row];
    [[unroll]] for (int each = row + 1; each < kUnknowns; ++each) {
      rest -= lower[each * kUnknowns + row] * solution[each];
    }
    solution[row] = rest / lower[row * kUnknowns + row];
  }
}

// Turns a vector about an axis of length 1 (Rodrigues).
vec3 turned_about(vec3 axis, float angle, vec3 vector) {
  float cosine = cos(angle);
  return cosine * vector + sin(angle) * cross(axis, vector) + (1.0 - cosine) * dot(axis, vector) * axis;
}

void move_by(float solution[kUnknowns]) {
  vec3 turn = vec3(solution[0], solution[1], solution[2]) / kLeverMm;
  vec3 shift = vec3(solution[3], solution[4], solution[5]);
  float angle = length(turn);
  vec3 axis = turn / max(angle, 1e-12);
  right = turned_about(axis, angle, right);
  down = turned_about(axis, angle, down);
  forward = turned_about(axis, angle, forward);
  origin = steady.pivot + turned_about(axis, angle, origin - steady.pivot) + shift;
  turned += turn;
  moved += shift;
}

void main() {
  uint thread = gl_LocalInvocationID.x;
  if (thread == 0u) {
    right = steady.right;
    down = steady.down;
    forward = steady.forward;
    origin = steady.origin;
    turned = vec3(0.0);
    moved = vec3(0.0);
  }
  barrier();
  int across = max(steady.now.cells_across, 1);
  int cells = steady.now.cells_across * steady.now.cells_down;
  for (int round = 0; round < kRounds; ++round) {
    float sum[kSums];
    [[unroll]] for (int each = 0; each < kSums; ++each) sum[each] = 0.0;
    for (int cell = int(thread); cell < cells; cell += int(kThreads)) {
      add_cell(ivec2(cell % across, cell / across), kLimits[round], sum);
    }
    [[unroll]] for (int each = 0; each < kSums; ++each) sums[each * int(kThreads) + int(thread)] = sum[each];
    barrier();
    if (thread < uint(kSums)) {
      float total = 0.0;
      for (int each = 0; each < int(kThreads); ++each) total += sums[int(thread) * int(kThreads) + each];
      totals[thread] = total;
    }
    barrier();
    if (thread == 0u) {
      float solution[kUnknowns];
      solve(solution);
      move_by(solution);
    }
    barrier();
  }
  if (thread > 0u) return;
  float weights = totals[kSums - 2];
  bool enough = weights >= kLeastCells && weights >= kLeastShare * totals[kSums - 1];
  alignment.right = right;
  alignment.down = down;
  alignment.forward = forward;
  alignment.origin = origin;
  alignment.found = enough && length(moved) <= kMostMm && length(turned) <= kMostTurn ? 1u : 0u;
}
