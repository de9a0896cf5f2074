// SPDX-License-Identifier: Apache-2.0
// Pass 1, slices: planes through the volume, each in its part of the picture, in grey
// (renderer/ALGORITHM.md, pass 1), or slabs about them. Black where nothing was scanned or it is cropped.
//
// Near tissue that the surface leaves out is dim, with a line at its end; so is what the scalpel has cut
// away.
//
// Reads: the parameters; the volume and the angle table (fan_volume.h).
// Writes: volume_colour, RGBA8, height x width of the picture, inside the parts of the planes.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "cast_parameters.h"
#include "near_tissue.h"

layout(local_size_x = 8, local_size_y = 8) in;

// As in cast.comp.
layout(constant_id = 2) const int kFrames = FANLIGHT_FRAMES_PARALLEL;

#define rays parameters[FANLIGHT_PARAMETER_INDEX]
layout(binding = FANLIGHT_BINDING_VOLUME_COLOUR, scalar) writeonly buffer Colours {
  uint volume_colour[];
};
#include "cut_mask.h"
#include "fan_volume.h"

// Of what near tissue is left in the planes.
const float kDimmed = 0.45;
const vec3 kLine = vec3(1.0, 0.75, 0.2);
// The same of what is cut away.
const float kCutDimmed = 0.3;
const vec3 kCutLine = vec3(0.35, 0.8, 1.0);
// Half of the line's width, in pixels.
const float kHalfLine = 0.9;

// Thickness of tissue of the brightest echo that lets 1 / e of a ray through, mm.
const float kXRayReach = 10.0;

// The echo of the slab about a point of a plane, 0 to 1; less than 0 where none of it is shown.
float slab_echo(vec3 at, vec3 normal) {
  float half_mm = 0.5 * float(rays.slab_samples - 1) * rays.slab_step;
  vec3 across = rays.slab_samples > 1 ? normal : vec3(0.0);
  // Half a step longer than the samples reach, so that rounding does not lose the outermost ones.
  float reach = half_mm + 0.5 * rays.slab_step;
  vec2 shown = between_frames(cropped(vec2(-reach, reach), at, across), at, across);
  float most = -1.0;
  float sum = 0.0;
  float count = 0.0;
  for (int number = 0; number < rays.slab_samples; ++number) {
    float t = float(number) * rays.slab_step - half_mm;
    float value = echo(at + t * across);
    bool is_shown = t >= shown.x && t <= shown.y && value >= 0.0;
    most = is_shown ? max(most, value) : most;
    sum += is_shown ? value : 0.0;
    count += is_shown ? 1.0 : 0.0;
  }
  if (rays.slab_samples == 1 || rays.slab_kind == FANLIGHT_SLAB_MAXIMUM || count == 0.0) return most;
  if (rays.slab_kind == FANLIGHT_SLAB_MEAN) return sum / count;
  return 1.0 - exp(-sum * rays.slab_step / kXRayReach);
}

// The colour of an echo at a point. `pixel_mm`: distance of the plane's pixels.
vec3 coloured(float value, vec3 at, float pixel_mm) {
  float from_axis = from_axis_of(at);
  VoxelPosition position = position_in_frame(at, from_axis);
  float angle = angle_between(at.z, at.y + rays.motor_radius, from_axis);
  float beyond_mm = (position.voxel.y - end_of_near_tissue(position.voxel.x, angle)) * near.row_mm;
  float line = clamp(kHalfLine + 0.5 - abs(beyond_mm) / pixel_mm, 0.0, 1.0);
  vec3 grey = vec3(beyond_mm < 0.0 ? kDimmed * value : value);
  return position.margin >= 0.0 ? mix(grey, kLine, line) : grey;
}

// What is cut away is dim too, with a line where it ends.
vec3 with_cuts(vec3 colour, vec3 at, float pixel_mm) {
  for (bool due = has_cuts(); due; due = false) {
    float share = cut_share(at);
    // Between a corner that is cut and one that is not, the share falls by 1.
    float beyond_mm = (share - 0.5) * rays.cut_cell;
    float line = clamp(kHalfLine + 0.5 - abs(beyond_mm) / pixel_mm, 0.0, 1.0);
    // Farther away nothing is known of the border; the line ends there where pixels are larger than cells.
    line *= clamp(4.0 - 8.0 * abs(share - 0.5), 0.0, 1.0);
    colour = mix(share >= 0.5 ? kCutDimmed * colour : colour, kCutLine, line);
  }
  return colour;
}

void main() {
  uvec2 pixel = gl_GlobalInvocationID.xy;
  if (pixel.x >= rays.width || pixel.y >= rays.height) return;
  int shown_slice = -1;
  for (uint slice = 0u; slice < rays.slices; ++slice) {
    uvec2 in_part = pixel - uvec2(rays.slice_planes[slice].left, rays.slice_planes[slice].top);
    // A pixel before the part wraps to a number beyond its size.
    bool inside = in_part.x < rays.slice_planes[slice].width && in_part.y < rays.slice_planes[slice].height;
    shown_slice = inside ? int(slice) : shown_slice;
  }
  for (int slice = shown_slice; slice >= 0; slice = -1) {
    vec3 at = rays.slice_planes[slice].origin + float(pixel.x) * rays.slice_planes[slice].right_step +
              float(pixel.y) * rays.slice_planes[slice].down_step;
    vec3 normal = normalize(cross(rays.slice_planes[slice].right_step, rays.slice_planes[slice].down_step));
    float value = slab_echo(at, normal);
    bool shown = value >= 0.0;
    float pixel_mm = length(rays.slice_planes[slice].right_step);
    vec3 colour = shown ? with_cuts(coloured(value, at, pixel_mm), at, pixel_mm) : vec3(0.0);
    volume_colour[pixel.y * rays.width + pixel.x] = packUnorm4x8(vec4(colour, 1.0));
  }
}
