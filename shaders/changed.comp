// Pass 1, where some frames were replaced by newer ones: which tiles have to be cast again. A ray's result can change only
// where a segment in which it looked, before or now, has an edge or something seen in it, and mixes samples of the
// replaced frames into its windows.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_control_flow_attributes : require
#include "bindings.h"
#include "cast_parameters.h"

layout(local_size_x = 8) in;  // tiles

// As in cast.comp.
layout(constant_id = 0) const int kWindow = 8;

layout(push_constant, scalar) uniform Changed { int first_changed; int last_changed; };  // frames
layout(binding = FANLIGHT_BINDING_SEGMENTS, scalar) readonly buffer Segments { uvec4 segments[]; };
layout(binding = FANLIGHT_BINDING_OLD_SEGMENTS, scalar) readonly buffer OldSegments { uvec4 old_segments[]; };
layout(binding = FANLIGHT_BINDING_REACHED, scalar) buffer Reached { uint reached[]; };
layout(binding = FANLIGHT_BINDING_TILE_LIST, scalar) buffer TileList { uint tile_list[]; };
CastParameters rays;
#include "angle_table.h"
#include "cell.h"

// Whether samples of the cell mix a voxel of the replaced frames.
bool mixes_changed(Cell cell) {
  ivec2 frames = frames_in(extent_of(cell));
  return frames.x <= last_changed && frames.y >= first_changed;
}

void main() {
  rays = parameters[FANLIGHT_THE_ONLY];
  uint tile = gl_GlobalInvocationID.x;
  if (tile >= cast_tiles().x * cast_tiles().y) return;
  Tile about = tile_numbered(tile);
  int samples = 1 << rays.segment_shift;
  // A window reaches back from its newest sample; and an edge that ends with its segment is placed by one sample more.
  float half_length = 0.5 * float(samples + kWindow);
  float first_middle = 0.5 * float(samples - kWindow);
  int count = int((min(reached[tile], rays.steps) + uint(samples) - 1u) >> rays.segment_shift);

  bool again = false;
  for (int part = 0; part < FANLIGHT_MOST_SEGMENTS / 32; ++part) {
    uint bits = segments[tile][part] | old_segments[tile][part];
    int inside = clamp(count - 32 * part, 0, 32);
    bits &= inside == 32 ? ~0u : (1u << inside) - 1u;
    while (bits != 0u && !again) {
      int segment = 32 * part + findLSB(bits);
      bits &= bits - 1u;
      again = mixes_changed(Cell(about, float(segment * samples) + first_middle, half_length));
    }
  }
  for (int once = again ? 0 : 1; once < 1; ++once) {
    tile_list[3u + atomicAdd(tile_list[0], 1u)] = tile;
    reached[tile] = 0u;
  }
}
