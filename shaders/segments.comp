// Pass 1, before the rays: which segments of a tile's rays can hold an edge or anything seen. A tile's rays are bounded
// together: the samples of a segment lie in a ball, the voxels that they mix lie in a box of frames, columns and rows
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

layout(binding = FANLIGHT_BINDING_CAST_PARAMETERS, scalar) uniform Parameters { CastParameters parameters; };
layout(binding = FANLIGHT_BINDING_BOUNDS, scalar) readonly buffer Bounds { uint bounds[]; };
layout(binding = FANLIGHT_BINDING_SEGMENTS, scalar) writeonly buffer Segments { uvec4 segments[]; };
// A copy of the parameters: read once, not at every step of the loops.
CastParameters rays;
#include "angle_table.h"
#include "blocks.h"

// A tile of 8 x 8 rays: from its middle to its outermost pixels.
float tile_reach;
// So much wider is a ball taken than it is, for rounding, and for the curve of what lies between a tile's corners.
const float kSlackShare = 1.02;
const float kSlackMm = 0.01;
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

// The samples of one ray lie at first + index * step, in mm.
struct Line {
  vec3 first;
  vec3 step;
};

Line line_of(vec2 pixel) {
  vec3 from = rays.origin + pixel.x * rays.right_step + pixel.y * rays.down_step;
  vec3 forward = rays.forward + pixel.x * rays.right_turn + pixel.y * rays.down_turn;
  return Line(from + rays.start * forward, rays.step * normalize(forward));
}

// The radius of the ball about the middle of a segment that holds the segment's samples on the rays of the corners. It is
// convex along the rays, so a line between its values at two segments bounds it between them.
float reach_about(vec2 middle, float index, float half_length) {
  Line through = line_of(middle);
  vec3 centre = through.first + index * through.step;
  float reach_squared = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    vec2 side = vec2((corner & 1) != 0 ? tile_reach : -tile_reach, (corner & 2) != 0 ? tile_reach : -tile_reach);
    Line line = line_of(middle + side);
    vec3 away = line.first + (index + ((corner & 4) != 0 ? half_length : -half_length)) * line.step - centre;
    reach_squared = max(reach_squared, dot(away, away));
  }
  return sqrt(reach_squared);
}

// First and last of the frames that samples in the ball mix; last < first for none.
ivec2 frames_about(vec3 centre, float reach) {
  float along = centre.y + rays.motor_radius;
  float from_axis = sqrt(along * along + centre.z * centre.z);
  float sine = reach / max(from_axis, 1e-6);
  float widened = sine / (1.0 + sqrt(max(1.0 - sine * sine, 0.0)));  // tangent of half the angle that the ball spans
  float middle = centre.z / max(from_axis + along, 1e-6);
  // tan(a - b) and tan(a + b)
  float below = 1.0 + middle * widened;
  float above = 1.0 - middle * widened;
  bool about_axis = sine >= 1.0;
  float first = about_axis || below <= 0.0 ? -1e6 : (middle - widened) / below;
  float last = about_axis || above <= 0.0 ? 1e6 : (middle + widened) / above;
  // An entry more on either side, for rounding.
  float lowest = texelFetch(angle_table, max(int(table_place(first)) - 1, 0)).x;
  float highest = texelFetch(angle_table, min(int(table_place(last)) + 2, int(rays.last_angle_entry))).x;
  bool beside = highest < 0.0 || lowest > rays.last_frame;
  ivec2 frames = ivec2(floor(clamp(vec2(lowest, highest), 0.0, rays.last_frame)));
  return beside ? ivec2(0, -1) : ivec2(frames.x, min(frames.y + 1, int(rays.last_frame)));
}

// The pixels along one axis of a frame between two places; last < first for none.
ivec2 pixels_between(float first, float last, float last_pixel) {
  bool beside = last < 0.0 || first > last_pixel;
  ivec2 pixels = ivec2(floor(clamp(vec2(first, last), 0.0, last_pixel)));
  return beside ? ivec2(0, -1) : ivec2(pixels.x, min(pixels.y + 1, int(last_pixel)));
}

// The bounds over the voxels that samples in the ball mix.
Levels levels_about(vec3 centre, float reach) {
  ivec2 frames = frames_about(centre, reach);
  float along = centre.y + rays.motor_radius;
  float rho = sqrt(along * along + centre.z * centre.z) - rays.motor_radius;
  vec2 across;
  vec2 down;
  if (kPolar) {
    vec2 in_plane = vec2(centre.x, rho + rays.probe_radius);
    float radius = length(in_plane);
    float middle = atan(in_plane.x, in_plane.y);
    float widened = reach < radius ? asin(min(reach / radius, 1.0)) : 4.0;
    across = vec2(middle - widened, middle + widened);
    down = vec2(radius - reach, radius + reach) - rays.probe_radius;
  } else {
    across = vec2(centre.x - reach, centre.x + reach);
    down = vec2(rho - reach, rho + reach);
  }
  ivec2 columns = pixels_between(across.x * rays.column_scale + rays.column_offset,
                                 across.y * rays.column_scale + rays.column_offset, rays.last_column);
  ivec2 rows = pixels_between(down.x * rays.row_scale + rays.row_offset, down.y * rays.row_scale + rays.row_offset,
                              rays.last_row);
  bool empty = columns.y < columns.x || rows.y < rows.x;
  // The bounds of block b hold from the block before it to the one after it.
  int blocks_across = blocks_along(uint(rays.last_column) + 1u);
  int blocks_down = blocks_along(uint(rays.last_row) + 1u);
  ivec2 first = min(ivec2(columns.x, rows.x) / FANLIGHT_BLOCK + 1, ivec2(blocks_across, blocks_down) - 1);
  ivec2 last = min(ivec2(columns.y, rows.y) / FANLIGHT_BLOCK, ivec2(blocks_across, blocks_down) - 1);
  uint least = 255u;
  uint greatest = 0u;
  for (int frame = frames.x; frame <= (empty ? -1 : frames.y); ++frame) {
    for (int y = first.y; y < last.y + 2; y += 3) {
      int row = (frame * blocks_down + min(y, blocks_down - 1)) * blocks_across;
      for (int x = first.x; x < last.x + 2; x += 3) {
        uint bound = bounds[row + min(x, blocks_across - 1)];
        least = min(least, least_of(bound));
        greatest = max(greatest, greatest_of(bound));
      }
    }
  }
  return Levels(float(least) / 255.0, float(greatest) / 255.0);
}

void main() {
  rays = parameters;
  uint tile = gl_GlobalInvocationID.x;
  uint tile_side = 8u * rays.pixel_stride;
  uint tiles_across = (rays.width + tile_side - 1u) / tile_side;
  uint tiles_down = (rays.height + tile_side - 1u) / tile_side;
  if (tile >= tiles_across * tiles_down) return;
  tile_reach = 0.5 * float(tile_side - 1u);
  vec2 middle = float(tile_side) * vec2(tile % tiles_across, tile / tiles_across) + tile_reach;
  Line through = line_of(middle);
  int samples = 1 << rays.segment_shift;
  float half_length = 0.5 * float(samples - 1);
  int count = int((rays.steps + uint(samples) - 1u) >> rays.segment_shift);
  float widest = float(max(count - 1, 1));
  float first_reach = reach_about(middle, half_length, half_length);
  float last_reach = reach_about(middle, half_length + widest * float(samples), half_length);
  float beside = 1.5 * float(rays.across) * rays.step;  // the window across the ray, to its corners

  // The last segments, this one first.
  Levels recent[kOldestReach + 1];
  [[unroll]] for (int back = 0; back <= kOldestReach; ++back) recent[back] = kNothing;
  int nearest_oldest = kHalf >> rays.segment_shift;
  uvec4 found = uvec4(0u);
  for (int part = 0; part < FANLIGHT_MOST_SEGMENTS / 32; ++part) {
    uint bits = 0u;
    for (int bit = 0; bit < min(32, count - 32 * part); ++bit) {
      int segment = 32 * part + bit;
      float share = float(segment) / widest;
      float reach = kSlackShare * (mix(first_reach, last_reach, share) + beside) + kSlackMm;
      vec3 centre = through.first + (float(segment * samples) + half_length) * through.step;
      [[unroll]] for (int back = kOldestReach; back > 0; --back) recent[back] = recent[back - 1];
      recent[0] = levels_about(centre, reach);

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
