// Pass 1, before the rays: which segments of a tile's rays can hold an edge or anything seen. A tile's rays are bounded
// together: the samples of a segment lie in a cell, the voxels that they mix lie in a box of frames, columns and rows
// about it, and the bounds over that box's blocks hold for all of them. The detector compares two means, so it exceeds the
// threshold only where the greatest level of the one half of its window exceeds the least of the other by that much.
// What is passed over by this rule could not have changed a ray's result.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_control_flow_attributes : require
#include "bindings.h"
#include "cast_parameters.h"

layout(local_size_x = 8) in;  // tiles

// As in cast.comp.
layout(constant_id = 0) const int kWindow = 8;
layout(constant_id = 1) const int kKeep = FANLIGHT_KEEP_NOTHING;
layout(constant_id = 2) const bool kPolar = false;

layout(binding = FANLIGHT_BINDING_BOUND_TEXELS) uniform usamplerBuffer bounds;
layout(binding = FANLIGHT_BINDING_SEGMENTS, scalar) writeonly buffer Segments { uvec4 segments[]; };
// A copy of the parameters: read once, not at every step of the loops.
CastParameters rays;
#include "angle_table.h"
#include "blocks.h"
#include "cell.h"

// So much more may levels differ than their bounds, for rounding: a fortieth of a grey level.
const float kSlackLevel = 1e-4;

const int kHalf = kWindow / 2;
const int kLeastSegment = 1 << FANLIGHT_LEAST_SEGMENT_SHIFT;
// How many segments back the samples of a window may lie whose newest sample lies in this one: those of the newest half
// reach so far, those of the oldest from the nearest to the farthest. Longer segments reach less far.
const int kNewestReach = (kHalf - 1 + kLeastSegment - 1) / kLeastSegment;
const int kOldestReach = (kWindow - 1 + kLeastSegment - 1) / kLeastSegment;

// Least and greatest grey level, 0 to 1; of nothing, where least is the larger.
struct Levels {
  float least;
  float greatest;
};

const Levels kNothing = Levels(1.0, 0.0);

Levels both(Levels a, Levels b) { return Levels(min(a.least, b.least), max(a.greatest, b.greatest)); }

// The pixels along one axis of a frame between two places; last < first for none.
ivec2 pixels_between(float first, float last, float last_pixel) {
  bool beside = last < 0.0 || first > last_pixel;
  ivec2 pixels = ivec2(floor(clamp(vec2(first, last), 0.0, last_pixel)));
  return beside ? ivec2(0, -1) : ivec2(pixels.x, min(pixels.y + 1, int(last_pixel)));
}

// The bounds over the voxels that samples in the cell mix.
Levels levels_in(Cell cell) {
  Extent extent = extent_of(cell);
  ivec2 frames = frames_in(extent);
  vec2 across = extent.x;
  vec2 down = extent.from_axis - rays.motor_radius;
  if (kPolar) {
    // A disc in the plane of the frame.
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
  ivec2 rows = pixels_between(down.x * rays.row_scale + rays.row_offset, down.y * rays.row_scale + rays.row_offset,
                              rays.last_row);
  bool empty = columns.y < columns.x || rows.y < rows.x;
  int blocks_across = blocks_along(uint(rays.last_column) + 1u);
  int blocks_down = blocks_along(uint(rays.last_row) + 1u);
  ivec2 first = ivec2(columns.x, rows.x) / FANLIGHT_BLOCK;
  ivec2 last = ivec2(columns.y, rows.y) / FANLIGHT_BLOCK;
  uint least = 255u;
  uint greatest = 0u;
  for (int frame = frames.x; frame <= (empty ? -1 : frames.y); ++frame) {
    for (int y = first.y; y <= last.y; y += FANLIGHT_BLOCKS_IN_BOUND) {
      int row = (frame * blocks_down + y) * blocks_across;
      for (int x = first.x; x <= last.x; x += FANLIGHT_BLOCKS_IN_BOUND) {
        uint bound = texelFetch(bounds, row + x).x;
        least = min(least, least_of(bound));
        greatest = max(greatest, greatest_of(bound));
      }
    }
  }
  return Levels(float(least) / 255.0, float(greatest) / 255.0);
}

void main() {
  rays = parameters[FANLIGHT_THE_ONLY];
  uint tile = gl_GlobalInvocationID.x;
  if (tile >= cast_tiles().x * cast_tiles().y) return;
  Tile about = tile_numbered(tile);
  int samples = 1 << rays.segment_shift;
  float half_length = 0.5 * float(samples - 1);
  int count = int((rays.steps + uint(samples) - 1u) >> rays.segment_shift);

  // The last segments, this one first.
  Levels recent[kOldestReach + 1];
  [[unroll]] for (int back = 0; back <= kOldestReach; ++back) recent[back] = kNothing;
  int nearest_oldest = kHalf >> rays.segment_shift;
  uvec4 found = uvec4(0u);
  for (int part = 0; part < FANLIGHT_MOST_SEGMENTS / 32; ++part) {
    uint bits = 0u;
    for (int bit = 0; bit < min(32, count - 32 * part); ++bit) {
      int segment = 32 * part + bit;
      [[unroll]] for (int back = kOldestReach; back > 0; --back) recent[back] = recent[back - 1];
      recent[0] = levels_in(Cell(about, float(segment * samples) + half_length, half_length));

      Levels newest = kNothing;
      [[unroll]] for (int back = 0; back <= kNewestReach; ++back) newest = both(newest, recent[back]);
      Levels oldest = kNothing;
      [[unroll]] for (int back = 0; back <= kOldestReach; ++back) {
        if (back >= nearest_oldest) oldest = both(oldest, recent[back]);
      }
      float rise = newest.greatest - oldest.least;
      float fall = oldest.greatest - newest.least;
      float edge = rays.edge_sign > 0 ? rise : rays.edge_sign < 0 ? fall : max(rise, fall);
      bool seen = kKeep == FANLIGHT_KEEP_COLOUR && recent[0].greatest >= rays.least_seen - kSlackLevel &&
                  recent[0].least <= rays.greatest_seen + kSlackLevel;
      bits |= edge + kSlackLevel > rays.threshold || seen ? 1u << bit : 0u;
    }
    found[part] = bits;
  }
  segments[tile] = found;
}
