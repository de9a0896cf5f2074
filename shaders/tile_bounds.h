// SPDX-License-Identifier: Apache-2.0
// Bounds the samples of all rays of a tile, one segment at a time, for empty_space.comp and
// dirty_tiles.comp. The bounds are conservative: no sample of the segment lies outside. The includer has
// declared the parameters as `rays`, included angle_table.h, and declared
//   int steps_beside_ray()   how far beside a ray echoes count
// Points are in the transducer frame, mm
// (fan_volume.h).
#ifndef FANLIGHT_SHADERS_TILE_BOUNDS_H
#define FANLIGHT_SHADERS_TILE_BOUNDS_H

// Side of a tile of 8 x 8 rays in pixels, and the distance from its middle to its outermost pixels.
uint tile_side() {
  return 8u * rays.pixel_stride;
}
float tile_reach() {
  return 0.5 * float(tile_side() - 1u);
}

// Tiles across and down.
uvec2 cast_tiles() {
  return (uvec2(rays.width, rays.height) + tile_side() - 1u) / tile_side();
}

// Bounds are widened by this factor and this length, for rounding, and for the curvature between the rays at
// the border of a tile.
const float kSlackFactor = 1.02;
const float kSlackMm = 0.01;
// The samples of one ray are the points first + index * step.
struct Line {
  vec3 first;
  vec3 step;
};

Line line_of(vec2 pixel) {
  vec3 from = rays.origin + pixel.x * rays.right_step + pixel.y * rays.down_step;
  vec3 forward = rays.forward + pixel.x * rays.right_turn + pixel.y * rays.down_turn;
  return Line(from + rays.start * forward, rays.step * normalize(forward));
}

// The outermost rays of a tile: at its corners, and in the middle of its edges. In perspective a wide tile
// bulges there beyond the line between its corners.
const int kOutermost = 8;
const vec2 kSides[kOutermost] = vec2[](vec2(-1, -1), vec2(0, -1), vec2(1, -1), vec2(-1, 0), vec2(1, 0),
                                       vec2(-1, 1), vec2(0, 1), vec2(1, 1));

// The outermost rays of a tile, relative to the ray of its middle.
struct Tile {
  // Perspective: how far rays reach beyond the lines between the outermost ones, as a fraction.
  float widening;
  Line middle;
  Line outermost[kOutermost];
};

Tile tile_with_number(uint number) {
  uint across = cast_tiles().x;
  vec2 middle = float(tile_side()) * vec2(number % across, number / across) + tile_reach();
  Tile tile;
  float turn = tile_reach() * length(rays.right_turn);
  tile.widening = turn * turn;
  tile.middle = line_of(middle);
  [[unroll]] for (int ray = 0; ray < kOutermost; ++ray) {
    Line line = line_of(middle + tile_reach() * kSides[ray]);
    tile.outermost[ray] = Line(line.first - tile.middle.first, line.step - tile.middle.step);
  }
  return tile;
}

// A segment of a tile's rays: the samples whose index differs from `index` by at most half_length.
struct Cell {
  Tile tile;
  float index;
  float half_length;
};

vec3 centre_of(Cell cell) {
  return cell.tile.middle.first + cell.index * cell.tile.middle.step;
}

// Half of the extent of the cell along a unit vector, from its centre, mm.
float reach_along(Cell cell, vec3 direction) {
  float reach = 0.0;
  [[unroll]] for (int ray = 0; ray < kOutermost; ++ray) {
    Line line = cell.tile.outermost[ray];
    float aside = abs(dot(line.first + cell.index * line.step, direction));
    reach = max(reach, aside + cell.half_length * abs(dot(cell.tile.middle.step + line.step, direction)));
  }
  float across = 1.5 * float(steps_beside_ray()) * rays.step;  // more than half of a square's diagonal
  return (kSlackFactor + cell.tile.widening) * (reach + across) + kSlackMm;
}

// The extent of a cell in coordinates of the sweep: x and distance from the sweep axis (smallest, largest),
// and the angles about that axis.
struct Extent {
  vec2 x;
  vec2 from_axis;
  float half_tangent;  // tan(half of the middle angle)
  float tangent;       // tan(largest difference from the middle angle)
};

Extent extent_of(Cell cell) {
  vec3 centre = centre_of(cell);
  float along = centre.y + rays.motor_radius;
  float from_axis = sqrt(along * along + centre.z * centre.z);
  // Unit vector away from the sweep axis, in (y, z).
  vec2 away = from_axis > 1e-6 ? vec2(along, centre.z) / from_axis : vec2(1.0, 0.0);
  float reach_x = reach_along(cell, vec3(1.0, 0.0, 0.0));
  float reach_away = reach_along(cell, vec3(0.0, away));
  float reach_around = reach_along(cell, vec3(0.0, -away.y, away.x));
  float nearest = from_axis - reach_away;
  float farthest = length(vec2(from_axis + reach_away, reach_around));
  return Extent(vec2(centre.x - reach_x, centre.x + reach_x), vec2(nearest, farthest),
                centre.z / max(from_axis + along, 1e-6),
                nearest > 0.0 ? min(reach_around / nearest, 1e6) : 1e6);
}

// First and last frame that samples of the cell interpolate; last < first: none.
ivec2 frames_in(Extent extent) {
  float tangent = extent.tangent;
  float widened = tangent / (1.0 + sqrt(1.0 + tangent * tangent));  // tan of half of it
  float middle = extent.half_tangent;
  // tan(a - b) and tan(a + b)
  float below = 1.0 + middle * widened;
  float above = 1.0 - middle * widened;
  float first = below <= 0.0 ? -1e6 : (middle - widened) / below;
  float last = above <= 0.0 ? 1e6 : (middle + widened) / above;
  // One more entry on either side, for rounding.
  float lowest = fetched_pair(angle_table, max(int(table_position(first)) - 1, 0)).x;
  float highest = fetched_pair(angle_table, min(int(table_position(last)) + 2, int(rays.last_angle_entry))).x;
  bool outside = highest < 0.0 || lowest > rays.last_frame;
  ivec2 frames = ivec2(floor(clamp(vec2(lowest, highest), 0.0, rays.last_frame)));
  // A cell that contains the axis reaches every angle.
  if (extent.from_axis.x <= 0.0) return ivec2(0, int(rays.last_frame));
  return outside ? ivec2(0, -1) : ivec2(frames.x, min(frames.y + 1, int(rays.last_frame)));
}

#endif
