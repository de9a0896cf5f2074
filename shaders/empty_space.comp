// SPDX-License-Identifier: Apache-2.0
// Pass 1, before the rays: finds the segments of each tile's rays that can hold an edge or, with
// compositing, a visible sample. Rays skip all other segments, which cannot change their result
// (renderer/ALGORITHM.md, pass 1).
//
// The rays of a tile are bounded together. The samples of a segment lie in a cell (tile_bounds.h). The
// voxels that they interpolate lie in a box of frames, columns and rows, and the minimum and maximum of the
// blocks of this box hold for all of the samples. The detector compares two means, so its step exceeds the
// threshold only if the maximum of one half of its window exceeds the minimum of the other half by more than
// the threshold.
//
// Reads: the parameters; the angle table; neighbour_min_max, one word for each block of the frames.
// Writes: segment_masks, uvec4 for each tile: one bit for each segment, 1 where it has to be sampled.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_control_flow_attributes : require
#include "bindings.h"
#include "buffer_access.h"
#include "cast_parameters.h"

layout(local_size_x = 8) in;  // tiles

// As in cast.comp.
layout(constant_id = 0) const int kWindow = 8;
layout(constant_id = 1) const int kKeep = FANLIGHT_KEEP_NOTHING;
layout(constant_id = 2) const int kFrames = FANLIGHT_FRAMES_PARALLEL;

FANLIGHT_WORDS_TO_READ(FANLIGHT_BINDING_NEIGHBOUR_MIN_MAX_TEXELS, NeighbourMinMaxWords, neighbour_min_max);
layout(binding = FANLIGHT_BINDING_SEGMENT_MASKS, scalar) writeonly buffer SegmentMasks {
  uvec4 segment_masks[];
};
// A copy of the parameters: read once, not in each iteration.
CastParameters rays;
#include "angle_table.h"

// What decides on edges. The direction of a layer is read from farther, once its edge is found.
int steps_beside_ray() {
  return rays.across;
}
#include "blocks.h"
#include "tile_bounds.h"

// Tolerance of the comparison of levels, for rounding: a fortieth of a grey level.
const float kSlackLevel = 1e-4;

const int kHalf = kWindow / 2;
const int kMinSegment = 1 << FANLIGHT_MIN_SEGMENT_SHIFT;
// A window whose newest sample lies in a segment reaches back over this number of segments with its newest
// half, and with its oldest half. With longer segments it reaches back over fewer.
const int kNewestReach = (kHalf - 1 + kMinSegment - 1) / kMinSegment;
const int kOldestReach = (kWindow - 1 + kMinSegment - 1) / kMinSegment;

// Minimum and maximum grey level of a region, 0 to 1. minimum > maximum: the empty region.
struct Levels {
  float minimum;
  float maximum;
};

const Levels kEmpty = Levels(1.0, 0.0);

Levels union_of(Levels a, Levels b) {
  return Levels(min(a.minimum, b.minimum), max(a.maximum, b.maximum));
}

// First and last pixel along one axis of a frame between two positions; last < first: none.
ivec2 pixels_between(float first, float last, float last_pixel) {
  bool outside = last < 0.0 || first > last_pixel;
  ivec2 pixels = ivec2(floor(clamp(vec2(first, last), 0.0, last_pixel)));
  return outside ? ivec2(0, -1) : ivec2(pixels.x, min(pixels.y + 1, int(last_pixel)));
}

// Minimum and maximum of the voxels that samples of the cell interpolate.
Levels levels_in(Cell cell) {
  Extent extent = extent_of(cell);
  ivec2 frames = frames_in(extent);
  vec2 across = extent.x;
  vec2 down = extent.from_axis - rays.motor_radius;
  if (kFrames == FANLIGHT_FRAMES_POLAR) {
    // The disc around the cell's rectangle in the plane of the frame.
    vec2 middle = vec2(0.5 * (extent.x.x + extent.x.y), 0.5 * (down.x + down.y) + rays.probe_radius);
    float reach = 0.5 * length(vec2(extent.x.y - extent.x.x, down.y - down.x));
    float radius = length(middle);
    float angle = atan(middle.x, middle.y);
    float widened = reach < radius ? asin(min(reach / radius, 1.0)) : 4.0;
    across = vec2(angle - widened, angle + widened);
    down = vec2(radius - reach, radius + reach) - rays.probe_radius;
  }
  ivec2 columns = pixels_between(across.x * rays.column_scale + rays.column_offset,
                                 across.y * rays.column_scale + rays.column_offset, rays.last_column);
  ivec2 rows = pixels_between(down.x * rays.row_scale + rays.row_offset,
                              down.y * rays.row_scale + rays.row_offset, rays.last_row);
  bool empty = columns.y < columns.x || rows.y < rows.x;
  int blocks_across = blocks_along(uint(rays.last_column) + 1u);
  int blocks_down = blocks_along(uint(rays.last_row) + 1u);
  ivec2 first = ivec2(columns.x, rows.x) / FANLIGHT_BLOCK;
  ivec2 last = ivec2(columns.y, rows.y) / FANLIGHT_BLOCK;
  uint minimum = 255u;
  uint maximum = 0u;
  for (int frame = frames.x; frame <= (empty ? -1 : frames.y); ++frame) {
    for (int y = first.y; y <= last.y; y += FANLIGHT_BLOCKS_IN_BOUND) {
      int row = (frame * blocks_down + y) * blocks_across;
      for (int x = first.x; x <= last.x; x += FANLIGHT_BLOCKS_IN_BOUND) {
        uint min_max = fetched(neighbour_min_max, row + x);
        minimum = min(minimum, min_of(min_max));
        maximum = max(maximum, max_of(min_max));
      }
    }
  }
  return Levels(float(minimum) / 255.0, float(maximum) / 255.0);
}

void main() {
  rays = parameters[FANLIGHT_PARAMETER_INDEX];
  uint tile = gl_GlobalInvocationID.x;
  if (tile >= cast_tiles().x * cast_tiles().y) return;
  Tile rays_of_tile = tile_with_number(tile);
  int samples = 1 << rays.segment_shift;
  float half_length = 0.5 * float(samples - 1);
  int count = int((rays.steps + uint(samples) - 1u) >> rays.segment_shift);

  // The levels of the present segment and of those before it, newest first.
  Levels recent[kOldestReach + 1];
  [[unroll]] for (int back = 0; back <= kOldestReach; ++back) recent[back] = kEmpty;
  int nearest_oldest = kHalf >> rays.segment_shift;
  uvec4 mask = uvec4(0u);
  for (int part = 0; part < FANLIGHT_MAX_SEGMENTS / 32; ++part) {
    uint bits = 0u;
    for (int bit = 0; bit < min(32, count - 32 * part); ++bit) {
      int segment = 32 * part + bit;
      [[unroll]] for (int back = kOldestReach; back > 0; --back) recent[back] = recent[back - 1];
      recent[0] = levels_in(Cell(rays_of_tile, float(segment * samples) + half_length, half_length));

      Levels newest = kEmpty;
      [[unroll]] for (int back = 0; back <= kNewestReach; ++back) newest = union_of(newest, recent[back]);
      Levels oldest = kEmpty;
      [[unroll]] for (int back = 0; back <= kOldestReach; ++back) {
        if (back >= nearest_oldest) oldest = union_of(oldest, recent[back]);
      }
      float rise = newest.maximum - oldest.minimum;
      float fall = oldest.maximum - newest.minimum;
      float edge = rays.edge_sign > 0 ? rise : rays.edge_sign < 0 ? fall : max(rise, fall);
      bool visible = kKeep == FANLIGHT_KEEP_COLOUR && recent[0].maximum >= rays.least_seen - kSlackLevel &&
                     recent[0].minimum <= rays.greatest_seen + kSlackLevel;
      bits |= edge + kSlackLevel > rays.threshold || visible ? 1u << bit : 0u;
    }
    mask[part] = bits;
  }
  segment_masks[tile] = mask;
}
