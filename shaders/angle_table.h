// SPDX-License-Identifier: Apache-2.0
// The angle table: from a point of the body to the frame coordinate (renderer/ALGORITHM.md, pass 1). The
// includer has declared the parameters as `rays`.
//
// Reads: angle_table, pairs of floats, an entry and the next one: the frame coordinate (0 for the first frame
// by ascending angle,
//   between frames a fraction), evenly spaced over tan(angle / 2). angle is the angle about the sweep axis
//   to the middle of the sweep. The half angle's tangent needs one division and no arc function.
#ifndef FANLIGHT_SHADERS_ANGLE_TABLE_H
#define FANLIGHT_SHADERS_ANGLE_TABLE_H

#include "buffer_access.h"
#include "whole_number.h"

FANLIGHT_PAIRS_TO_READ(FANLIGHT_BINDING_ANGLE_TABLE, AngleTablePairs, angle_table);

// The position in the table, in entries, clamped to the table.
float table_position(float half_tangent) {
  return clamp(half_tangent * rays.angle_scale + rays.angle_offset, 0.0, rays.last_angle_entry);
}

// Two neighbouring entries of the table, and the fraction between them.
struct Angle {
  float below;
  float above;
  float fraction;
};

// Looks up the half plane through the sweep axis in which the point (along, across) lies. `length` is its
// distance from the axis, mm.
Angle angle_at(float across, float along, float length) {
  float position = table_position(across / max(length + along, 1e-6));
  float below = min(floor(position), rays.last_angle_entry - 1.0);
  vec2 entries = fetched_pair(angle_table, whole(below));
  return Angle(entries.x, entries.y, position - below);
}

float frame_of(Angle angle) {
  // Interpolated: the nearest entry of a table eight times as large moved flat edges by tenths of a step.
  // Clamped: rounding must not make a sample just inside the first or last frame read a frame that does not
  // exist.
  return clamp(mix(angle.below, angle.above, angle.fraction), 0.0, rays.last_frame);
}

float frame_at(float across, float along, float length) {
  return frame_of(angle_at(across, along, length));
}

#endif
