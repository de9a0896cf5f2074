// A tile's rays bounded together: where the samples of a segment can lie. The includer has declared the parameters as `rays`
// and included angle_table.h.
#ifndef FANLIGHT_SHADERS_CELL_H
#define FANLIGHT_SHADERS_CELL_H

// Pixels along a side of a tile of 8 x 8 rays, and from its middle to its outermost ones.
uint tile_side() { return 8u * rays.pixel_stride; }
float tile_reach() { return 0.5 * float(tile_side() - 1u); }

uvec2 cast_tiles() { return (uvec2(rays.width, rays.height) + tile_side() - 1u) / tile_side(); }

// So much wider is a cell taken than it is, for rounding, and for the curve of what lies between a tile's corners.
const float kSlackShare = 1.02;
const float kSlackMm = 0.01;
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

// A tile's outermost rays: those of its corners, and of the middles of its edges, since rays from an eye reach farther
// there than between the corners where a tile is wide.
const int kOutermost = 8;
const vec2 kSides[kOutermost] = vec2[](vec2(-1, -1), vec2(0, -1), vec2(1, -1), vec2(-1, 0), vec2(1, 0), vec2(-1, 1),
                                       vec2(0, 1), vec2(1, 1));

// The rays of a tile's corners, seen from the ray of its middle.
struct Tile {
  float bulge;  // how much farther rays from an eye reach between the outermost ones, as a share
  Line middle;
  Line corners[kOutermost];
};

Tile tile_numbered(uint number) {
  uint across = cast_tiles().x;
  vec2 middle = float(tile_side()) * vec2(number % across, number / across) + tile_reach();
  Tile tile;
  float turn = tile_reach() * length(rays.right_turn);
  tile.bulge = turn * turn;
  tile.middle = line_of(middle);
  [[unroll]] for (int corner = 0; corner < kOutermost; ++corner) {
    Line line = line_of(middle + tile_reach() * kSides[corner]);
    tile.corners[corner] = Line(line.first - tile.middle.first, line.step - tile.middle.step);
  }
  return tile;
}

// A segment of a tile's rays: all of its samples lie within half_length samples of the index.
struct Cell {
  Tile tile;
  float index;
  float half_length;
};

vec3 centre_of(Cell cell) { return cell.tile.middle.first + cell.index * cell.tile.middle.step; }

// How far the cell reaches from its centre along a unit vector, to either side.
float reach_along(Cell cell, vec3 direction) {
  float reach = 0.0;
  [[unroll]] for (int corner = 0; corner < kOutermost; ++corner) {
    Line line = cell.tile.corners[corner];
    float aside = abs(dot(line.first + cell.index * line.step, direction));
    reach = max(reach, aside + cell.half_length * abs(dot(cell.tile.middle.step + line.step, direction)));
  }
  float across = 1.5 * float(rays.across) * rays.step;  // the window across the ray, to its corners
  return (kSlackShare + cell.tile.bulge) * (reach + across) + kSlackMm;
}

// What the cell covers: x, the distance from the sweep axis, and angles about that axis, by the tangent of half the middle
// one and by that of what they reach to either side of it.
struct Extent {
  vec2 x;
  vec2 from_axis;
  float half_tangent;
  float tangent;
};

Extent extent_of(Cell cell) {
  vec3 centre = centre_of(cell);
  float along = centre.y + rays.motor_radius;
  float from_axis = sqrt(along * along + centre.z * centre.z);
  // Away from the sweep axis, and about it.
  vec2 away = from_axis > 1e-6 ? vec2(along, centre.z) / from_axis : vec2(1.0, 0.0);
  float reach_x = reach_along(cell, vec3(1.0, 0.0, 0.0));
  float reach_away = reach_along(cell, vec3(0.0, away));
  float reach_about = reach_along(cell, vec3(0.0, -away.y, away.x));
  float nearest = from_axis - reach_away;
  float farthest = length(vec2(from_axis + reach_away, reach_about));
  return Extent(vec2(centre.x - reach_x, centre.x + reach_x), vec2(nearest, farthest),
                centre.z / max(from_axis + along, 1e-6), nearest > 0.0 ? min(reach_about / nearest, 1e6) : 1e6);
}

// First and last of the frames that samples of the cell mix; last < first for none.
ivec2 frames_in(Extent extent) {
  float tangent = extent.tangent;
  float widened = tangent / (1.0 + sqrt(1.0 + tangent * tangent));  // that of half the angle
  float middle = extent.half_tangent;
  // tan(a - b) and tan(a + b)
  float below = 1.0 + middle * widened;
  float above = 1.0 - middle * widened;
  float first = below <= 0.0 ? -1e6 : (middle - widened) / below;
  float last = above <= 0.0 ? 1e6 : (middle + widened) / above;
  // An entry more on either side, for rounding.
  float lowest = texelFetch(angle_table, max(int(table_place(first)) - 1, 0)).x;
  float highest = texelFetch(angle_table, min(int(table_place(last)) + 2, int(rays.last_angle_entry))).x;
  bool beside = highest < 0.0 || lowest > rays.last_frame;
  ivec2 frames = ivec2(floor(clamp(vec2(lowest, highest), 0.0, rays.last_frame)));
  // At the axis anything is within reach.
  if (extent.from_axis.x <= 0.0) return ivec2(0, int(rays.last_frame));
  return beside ? ivec2(0, -1) : ivec2(frames.x, min(frames.y + 1, int(rays.last_frame)));
}

#endif
