// SPDX-License-Identifier: Apache-2.0
// Samples the volume at points of the body (renderer/ALGORITHM.md, pass 1). The includer has declared the
// parameters as `rays`, and the specialisation constant kFrames (FANLIGHT_FRAMES_...).
//
// Points are in the transducer frame, mm: x lateral, y depth below the probe face, z elevation. The sweep
// axis is parallel to x, motor_radius behind the probe face.
//
// Reads: the volume, 8 bit grey levels. Without FANLIGHT_GATHERING it is a 3D texture. With
//   FANLIGHT_GATHERING it is the packed words of renderer/volume/frame_preparer.hpp, interpolated here: a
//   processor gathers words faster than it samples a texture.
#ifndef FANLIGHT_SHADERS_FAN_VOLUME_H
#define FANLIGHT_SHADERS_FAN_VOLUME_H

#include "buffer_access.h"

#ifdef FANLIGHT_GATHERING
FANLIGHT_WORDS_TO_READ(FANLIGHT_BINDING_PACKED, PackedColumnsWords, packed_columns);
#else
layout(binding = FANLIGHT_BINDING_VOLUME) uniform sampler3D volume;
#endif
#include "angle_table.h"
#include "whole_number.h"

// The angle between (across, along) and the second axis, rad, from -90 to 90 degrees. Halves the angle twice
// by the tangent of the half angle, then sums the series of the arc tangent. The first omitted term is below
// 1e-7 rad.
float angle_between(float across, float along, float length) {
  float half_tangent = across / max(length + along, 1e-6);
  float t = half_tangent / (1.0 + sqrt(1.0 + half_tangent * half_tangent));
  float u = t * t;
  float series = 1.0 / 13.0;
  series = 1.0 / 11.0 - u * series;
  series = 1.0 / 9.0 - u * series;
  series = 1.0 / 7.0 - u * series;
  series = 1.0 / 5.0 - u * series;
  series = 1.0 / 3.0 - u * series;
  return 4.0 * t * (1.0 - u * series);
}

#ifdef FANLIGHT_GATHERING
// The four words around a voxel position: two columns of two frames, each with four rows. The upper of the
// two rows begins at bit `shift`.
struct Voxels {
  uvec4 words;
  int shift;
  vec3 fraction;
};

Voxels voxels_at(vec3 voxel) {
  vec3 inside = clamp(voxel, vec3(0.0), vec3(rays.last_column, rays.last_row, rays.last_frame));
  vec3 first = floor(inside);
  // A packed row begins every three rows. Half a row protects the quotient from rounding.
  float packed_row = floor((first.y + 0.5) * (1.0 / 3.0));
  int here = (whole(first.z) * rays.packed_rows + whole(packed_row)) * rays.packed_stride + whole(first.x);
  int behind = here + rays.packed_rows * rays.packed_stride;
  uvec4 words = uvec4(fetched(packed_columns, here), fetched(packed_columns, here + 1),
                      fetched(packed_columns, behind), fetched(packed_columns, behind + 1));
  return Voxels(words, whole(8.0 * (first.y - 3.0 * packed_row)), inside - first);
}

// The trilinear interpolation of a texture's linear filter, 0 to 1.
float mixed(Voxels voxels) {
  uvec4 words = voxels.words >> voxels.shift;
  vec4 rows = mix(vec4(ivec4(words & 0xFFu)), vec4(ivec4(words >> 8 & 0xFFu)), voxels.fraction.y);
  vec2 columns = mix(rows.xz, rows.yw, voxels.fraction.x);
  return mix(columns.x, columns.y, voxels.fraction.z) * (1.0 / 255.0);
}

// Whether all voxels that are mixed were scanned.
bool scanned(Voxels voxels) {
  if (kFrames != FANLIGHT_FRAMES_MASKED) return true;
  uvec4 words = voxels.words >> voxels.shift;
  uvec4 darkest = min(words & 0xFFu, words >> 8 & 0xFFu);
  return min(min(darkest.x, darkest.y), min(darkest.z, darkest.w)) > 0u;
}
#else
struct Voxels {
  float mixed;
  float darkest;  // of the voxels that are mixed; FANLIGHT_FRAMES_MASKED only
};

Voxels voxels_at(vec3 voxel) {
  Voxels voxels = Voxels(textureLod(volume, (voxel + 0.5) * rays.voxel_scale, 0.0).x, 1.0);
  if (kFrames != FANLIGHT_FRAMES_MASKED) return voxels;
  vec3 last = vec3(rays.last_column, rays.last_row, rays.last_frame);
  ivec3 first = ivec3(floor(clamp(voxel, vec3(0.0), last)));
  for (int corner = 0; corner < 8; ++corner) {
    ivec3 at = min(first + ivec3(corner & 1, corner >> 1 & 1, corner >> 2), ivec3(last));
    voxels.darkest = min(voxels.darkest, texelFetch(volume, at, 0).x);
  }
  return voxels;
}
float mixed(Voxels voxels) {
  return voxels.mixed;
}
bool scanned(Voxels voxels) {
  return voxels.darkest > 0.0;
}
#endif

// A point between the first and last frame, in voxels.
struct VoxelPosition {
  vec3 voxel;  // column, row, frame
  // The smallest of the distances to the borders of the frame and of its sector, in various units. Negative:
  // not scanned.
  float margin;
};

// Column, row and margin of a point. `from_axis`: its distance from the sweep axis.
VoxelPosition position_in_frame(vec3 at, float from_axis) {
  float rho = from_axis - rays.motor_radius;
  float from_apex = rho + rays.probe_radius;
  float reach = at.x * at.x + from_apex * from_apex;
  VoxelPosition position;
  if (kFrames == FANLIGHT_FRAMES_POLAR) {
    float radius = sqrt(reach);
    position.voxel.x = angle_between(at.x, from_apex, radius) * rays.column_scale + rays.column_offset;
    position.voxel.y = (radius - rays.probe_radius) * rays.row_scale + rays.row_offset;
  } else {
    position.voxel.x = at.x * rays.column_scale + rays.column_offset;
    position.voxel.y = rho * rays.row_scale + rays.row_offset;
  }
  position.voxel.z = 0.0;
  float beside = from_apex * rays.sector_tangent - abs(at.x) - rays.sector_margin;
  float within = min(reach - rays.sector_near_squared, rays.sector_far_squared - reach);
  float column = min(position.voxel.x, rays.last_column - position.voxel.x);
  float row = min(position.voxel.y, rays.last_row - position.voxel.y);
  position.margin = min(min(beside, within), min(column, row));
  return position;
}

float from_axis_of(vec3 at) {
  float along_axis = at.y + rays.motor_radius;
  return sqrt(along_axis * along_axis + at.z * at.z);
}

// The echo at a point between the first and last frame, 0 to 1; negative where nothing was scanned.
float echo(vec3 at) {
  float from_axis = from_axis_of(at);
  VoxelPosition position = position_in_frame(at, from_axis);
  position.voxel.z = frame_at(at.z, at.y + rays.motor_radius, from_axis);
  Voxels voxels = voxels_at(position.voxel);
  float value = mixed(voxels);
  return position.margin >= 0.0 && scanned(voxels) ? value : -1.0;
}

// Clips the interval (first, last) of t to a + b t >= 0. last < first: empty.
vec2 cut(vec2 part, float a, float b) {
  float at = -a / b;
  return b > 0.0   ? vec2(max(part.x, at), part.y)
         : b < 0.0 ? vec2(part.x, min(part.y, at))
         : a < 0.0 ? vec2(1.0, 0.0)
                   : part;
}

// Clips the interval of the ray from + t * forward to the crop box and both clip planes.
vec2 cropped(vec2 part, vec3 from, vec3 forward) {
  for (int axis = 0; axis < 3; ++axis) {
    part = cut(part, from[axis] - rays.crop_lowest[axis], forward[axis]);
    part = cut(part, rays.crop_highest[axis] - from[axis], -forward[axis]);
  }
  part = cut(part, dot(rays.clip1.xyz, from) - rays.clip1.w, dot(rays.clip1.xyz, forward));
  part = cut(part, dot(rays.clip2.xyz, from) - rays.clip2.w, dot(rays.clip2.xyz, forward));
  return part;
}

// Clips the interval of the ray to the region between the first and last frame.
vec2 between_frames(vec2 part, vec3 from, vec3 forward) {
  // With the sweep axis as the origin, a frame is a half plane.
  vec2 about_axis = vec2(from.y + rays.motor_radius, from.z);
  vec2 first = vec2(-rays.first_angle.y, rays.first_angle.x);
  vec2 last = vec2(rays.last_angle.y, -rays.last_angle.x);
  part = cut(part, dot(about_axis, first), dot(forward.yz, first));
  return cut(part, dot(about_axis, last), dot(forward.yz, last));
}

#endif
