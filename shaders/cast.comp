// Pass 1: one ray a pixel through the fan, sampled through the fan table (design, section 4).
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "cast_parameters.h"

layout(local_size_x = 8, local_size_y = 8) in;  // a tile

// Samples that the detector compares, even. A constant, so that the loop over the window unrolls and the
// window lives in registers: indexed at run time it would live in memory.
layout(constant_id = 0) const int kWindow = 8;
// Off: the ray ends at the surface and no colour is kept.
layout(constant_id = 1) const bool kComposite = false;

// Tiles are numbered along the rows of tiles; a work group takes the one of its own number after this.
layout(push_constant, scalar) uniform Band { uint first_tile; };
layout(binding = FANLIGHT_BINDING_CAST_PARAMETERS, scalar) uniform Parameters { CastParameters rays; };
layout(binding = FANLIGHT_BINDING_VOLUME) uniform sampler3D volume;
layout(binding = FANLIGHT_BINDING_FAN_TABLE) uniform sampler2D fan_table;
layout(binding = FANLIGHT_BINDING_DEPTH, scalar) writeonly buffer DepthMap { float depth[]; };
layout(binding = FANLIGHT_BINDING_VOLUME_COLOUR, scalar) writeonly buffer Colours { uint volume_colour[]; };

// An opacity from which nothing behind changes the picture by a level of 255.
const float kOpaque = 0.997;

// The echo at a point of the fan, 0 to 1, or negative where nothing was scanned: above the probe face or
// beside the sector. The ray has been cut to the frames already.
float echo(vec3 at) {
  vec2 in_fan = textureLod(fan_table, at.zy * rays.table_scale + rays.table_offset, 0.0).xy;
  // The table is interpolated across the first and last frame, beyond which it goes on: a sample just inside could
  // else reach for a frame that is not there.
  float frame = clamp(in_fan.y, 0.0, rays.last_frame);
  vec3 voxel = vec3(at.x * rays.column_scale + rays.column_offset, in_fan.x * rays.row_scale + rays.row_offset, frame);
  float value = textureLod(volume, (voxel + 0.5) * rays.voxel_scale, 0.0).x;

  // Each distance is positive on the scanned side: the smallest decides, without a branch.
  float from_apex = in_fan.x + rays.sector_radius;
  float reach = at.x * at.x + from_apex * from_apex;
  float beside = from_apex * rays.sector_tangent - abs(at.x) - rays.sector_margin;
  float within = min(reach - rays.sector_near_squared, rays.sector_far_squared - reach);
  return min(min(beside, within), min(voxel.y, rays.last_row - voxel.y)) >= 0.0 ? value : -1.0;
}

// The part of a ray, from + t * forward, that satisfies a + b t >= 0, as a narrower (first, last).
vec2 cut(vec2 part, float a, float b) {
  float at = -a / b;
  return b > 0.0   ? vec2(max(part.x, at), part.y)
         : b < 0.0 ? vec2(part.x, min(part.y, at))
         : a < 0.0 ? vec2(1.0, 0.0)
                   : part;
}

// The part of a ray between the first and last column, the first and last frame, and within the last row:
// a convex body, so one stretch. Empty where its end lies before its start.
vec2 stretch_in_frames(vec3 from) {
  vec2 part = vec2(0.0, 1e6);
  part = cut(part, from.x - rays.left, rays.forward.x);
  part = cut(part, rays.right - from.x, -rays.forward.x);

  // About the sweep axis: y' = y + motor radius. A frame's angle is its half plane.
  vec2 about_axis = vec2(from.y + rays.motor_radius, from.z);
  vec2 forward = rays.forward.yz;
  vec2 first = vec2(-rays.first_angle.y, rays.first_angle.x);
  vec2 last = vec2(rays.last_angle.y, -rays.last_angle.x);
  part = cut(part, dot(about_axis, first), dot(forward, first));
  part = cut(part, dot(about_axis, last), dot(forward, last));

  // |about_axis + t * forward| <= farthest
  float a = dot(forward, forward);
  float half_b = dot(about_axis, forward);
  float c = dot(about_axis, about_axis) - rays.farthest * rays.farthest;
  float root = half_b * half_b - a * c;
  vec2 disc = a > 1e-12 ? (vec2(-half_b) + vec2(-1.0, 1.0) * sqrt(max(root, 0.0))) / a : vec2(0.0, 1e6);
  bool misses = a > 1e-12 ? root < 0.0 : c > 0.0;
  return misses ? vec2(1.0, 0.0) : vec2(max(part.x, disc.x), min(part.y, disc.y));
}

// Colour of an echo in the composited volume: dark red to bone.
vec3 tissue_colour(float value) { return mix(vec3(0.35, 0.12, 0.08), vec3(1.0, 0.92, 0.82), value); }

void main() {
  uint tile = first_tile + gl_WorkGroupID.x;
  uint tiles_across = (rays.width + 7u) / 8u;
  uvec2 pixel = 8u * uvec2(tile % tiles_across, tile / tiles_across) + gl_LocalInvocationID.xy;
  if (pixel.x >= rays.width || pixel.y >= rays.height) return;

  vec3 from = rays.origin + float(pixel.x) * rays.right_step + float(pixel.y) * rays.down_step +
              rays.start * rays.forward;
  vec3 along = rays.step * rays.forward;
  // Whole samples only, so that cutting a ray never moves one.
  vec2 stretch = stretch_in_frames(from) / rays.step;
  uint sample_index = uint(clamp(ceil(stretch.x), 0.0, float(rays.steps)));
  uint end = uint(clamp(floor(stretch.y) + 1.0, 0.0, float(rays.steps)));

  float window[kWindow];
  for (int slot = 0; slot < kWindow; ++slot) window[slot] = 0.0;
  float difference = 0.0;      // sum of the newest half of the window - sum of the oldest half
  float last_difference = 0.0;
  int scanned_in_a_row = 0;    // an edge of the fan is not an edge of tissue
  float surface = FANLIGHT_NO_SURFACE;
  vec3 colour = vec3(0.0);
  float opacity = 0.0;
  const float level = rays.threshold * float(kWindow / 2);

  // The circular buffer is the inner loop: slot is a constant once it is unrolled.
  bool done = false;
  while (sample_index < end && !done) {
    for (int slot = 0; slot < kWindow; ++slot) {
      float value = echo(from + float(sample_index) * along);
      scanned_in_a_row = value < 0.0 ? 0 : scanned_in_a_row + 1;
      value = max(value, 0.0);

      // The sample that moves from the newest half to the oldest, and the one that leaves.
      float middle = window[(slot + kWindow / 2) % kWindow];
      float oldest = window[slot];
      window[slot] = value;
      difference += value - 2.0 * middle + oldest;

      float edge = rays.edge_sign == 0 ? abs(difference) : float(rays.edge_sign) * difference;
      bool within = scanned_in_a_row >= kWindow && sample_index < end;
      bool crossed = within && surface < 0.0 && edge > level;
      // The edge lies between the two halves; the crossing of the level lies between this step and the last.
      float last_edge = scanned_in_a_row > kWindow ? last_difference : edge;
      float beyond = edge > last_edge ? clamp((edge - level) / (edge - last_edge), 0.0, 1.0) : 0.0;
      float index = float(sample_index) - float(kWindow / 2) + 0.5 - beyond;
      surface = crossed ? rays.start + index * rays.step : surface;
      last_difference = edge;

      if (kComposite) {
        // The window's last round may go beyond the ray's end.
        float share = float(sample_index < end) * clamp((value - rays.transparent) * rays.ramp_scale, 0.0, 1.0) * rays.step_opacity;
        colour += (1.0 - opacity) * share * tissue_colour(value);
        opacity += (1.0 - opacity) * share;
      }
      ++sample_index;
    }
    done = kComposite ? opacity >= kOpaque : surface >= 0.0;
  }

  uint index = pixel.y * rays.width + pixel.x;
  depth[index] = surface;
  volume_colour[index] = packUnorm4x8(vec4(colour, 1.0));
}
