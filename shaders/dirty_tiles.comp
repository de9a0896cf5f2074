// SPDX-License-Identifier: Apache-2.0
// Pass 1, where some frames were replaced by newer ones: finds the tiles to cast again
// (renderer/ALGORITHM.md, pass 1). The result of a ray can change only in a segment that it read, whose bit
// is set now or was set before, and whose windows interpolate a replaced frame.
//
// Reads: the parameters; the angle table; the push constants; segment_masks and old_segment_masks, one bit
//   for each segment of a tile's rays, now and before; sample_ends of each tile.
// Writes: tile_list, the number of tiles, 1, 1 (an indirect dispatch) and the numbers of the tiles, in any
//   order; sample_ends, 0 for these tiles.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_control_flow_attributes : require
#include "bindings.h"
#include "cast_parameters.h"

layout(local_size_x = 8) in;  // tiles

// As in cast.comp.
layout(constant_id = 0) const int kWindow = 8;
layout(constant_id = 3) const int kPlace = FANLIGHT_PLACE_REFINED;

layout(push_constant, scalar) uniform Changed {
  int first_changed;  // index of a frame, by ascending angle
  int last_changed;
};
layout(binding = FANLIGHT_BINDING_SEGMENT_MASKS, scalar) readonly buffer SegmentMasks {
  uvec4 segment_masks[];
};
layout(binding = FANLIGHT_BINDING_OLD_SEGMENT_MASKS, scalar) readonly buffer OldSegmentMasks {
  uvec4 old_segment_masks[];
};
layout(binding = FANLIGHT_BINDING_SAMPLE_ENDS, scalar) buffer SampleEnds {
  uint sample_ends[];
};
layout(binding = FANLIGHT_BINDING_DIRTY_TILES, scalar) buffer TileList {
  uint tile_list[];
};
// A copy of the parameters: read once, not in each iteration.
CastParameters rays;
#include "angle_table.h"

int steps_beside_ray() {
  return rays.beside;
}
#include "tile_bounds.h"

// Samples of the cell interpolate a replaced frame.
bool mixes_changed(Cell cell) {
  ivec2 frames = frames_in(extent_of(cell));
  return frames.x <= last_changed && frames.y >= first_changed;
}

void main() {
  rays = parameters[FANLIGHT_PARAMETER_INDEX];
  uint tile = gl_GlobalInvocationID.x;
  if (tile >= cast_tiles().x * cast_tiles().y) return;
  Tile rays_of_tile = tile_with_number(tile);
  int samples = 1 << rays.segment_shift;
  // A window reaches back by kWindow - 1 samples, and the peak of an edge at the end of a segment depends on
  // one more sample behind it.
  float half_length = 0.5 * float(samples + kWindow);
  // The level of the tissue is read from half a window more, on either side (surface_place.h).
  if (kPlace == FANLIGHT_PLACE_LEVEL) half_length += 0.5 * float(kWindow);
  float first_middle = 0.5 * float(samples - kWindow);
  int count = int((min(sample_ends[tile], rays.steps) + uint(samples) - 1u) >> rays.segment_shift);

  bool dirty = false;
  for (int part = 0; part < FANLIGHT_MAX_SEGMENTS / 32; ++part) {
    uint bits = segment_masks[tile][part] | old_segment_masks[tile][part];
    int valid = clamp(count - 32 * part, 0, 32);
    bits &= valid == 32 ? ~0u : (1u << valid) - 1u;
    while (bits != 0u && !dirty) {
      int segment = 32 * part + findLSB(bits);
      bits &= bits - 1u;
      dirty = mixes_changed(Cell(rays_of_tile, float(segment * samples) + first_middle, half_length));
    }
  }
  for (int once = dirty ? 0 : 1; once < 1; ++once) {
    tile_list[3u + atomicAdd(tile_list[0], 1u)] = tile;
    sample_ends[tile] = 0u;
  }
}
