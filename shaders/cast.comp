// Pass 1: one ray a pixel through the fan, sampled through the fan table (design, section 4).
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "cast_parameters.h"

layout(local_size_x = 8, local_size_y = 8) in;

// Samples that the detector compares, even. A constant, so that the loop over the window unrolls and the
// window lives in registers: indexed at run time it would live in memory.
layout(constant_id = 0) const int kWindow = 8;
// Off: the ray ends at the surface and no colour is kept.
layout(constant_id = 1) const bool kComposite = false;

layout(binding = FANLIGHT_BINDING_CAST_PARAMETERS, scalar) uniform Parameters { CastParameters rays; };
layout(binding = FANLIGHT_BINDING_VOLUME) uniform sampler3D volume;
layout(binding = FANLIGHT_BINDING_FAN_TABLE) uniform sampler2D fan_table;
layout(binding = FANLIGHT_BINDING_DEPTH, scalar) writeonly buffer DepthMap { float depth[]; };
layout(binding = FANLIGHT_BINDING_VOLUME_COLOUR, scalar) writeonly buffer Colours { uint volume_colour[]; };

// An opacity from which nothing behind is seen any more.
const float kOpaque = 0.98;

// The echo at a point, 0 to 1, or -1 where nothing was scanned.
float echo(vec3 at) {
  vec2 in_fan = textureLod(fan_table, at.zy * rays.table_scale + rays.table_offset, 0.0).xy;
  float from_apex = in_fan.x + rays.sector_radius;
  vec3 voxel = vec3(at.x * rays.column_scale + rays.column_offset,
                    in_fan.x * rays.row_scale + rays.row_offset, in_fan.y);
  float reach = at.x * at.x + from_apex * from_apex;
  bool scanned = all(greaterThanEqual(voxel, vec3(0.0))) && all(lessThanEqual(voxel, rays.last_voxel)) &&
                 abs(at.x) + rays.sector_margin <= from_apex * rays.sector_tangent &&
                 reach >= rays.sector_near * rays.sector_near && reach <= rays.sector_far * rays.sector_far;
  float value = textureLod(volume, (voxel + 0.5) * rays.voxel_scale, 0.0).x;
  return scanned ? value : -1.0;
}

// Colour of an echo in the composited volume: dark red to bone.
vec3 tissue_colour(float value) { return mix(vec3(0.35, 0.12, 0.08), vec3(1.0, 0.92, 0.82), value); }

void main() {
  uvec2 pixel = gl_GlobalInvocationID.xy;
  if (pixel.x >= rays.width || pixel.y >= rays.height) return;

  vec3 from = rays.origin + float(pixel.x) * rays.right_step + float(pixel.y) * rays.down_step +
              rays.start * rays.forward;
  vec3 along = rays.step * rays.forward;

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
  uint sample_index = 0;
  bool done = false;
  while (sample_index < rays.steps && !done) {
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
      bool crossed = surface < 0.0 && scanned_in_a_row >= kWindow && edge > level && sample_index < rays.steps;
      // The edge lies between the two halves; the crossing of the level lies between this step and the last.
      float last_edge = scanned_in_a_row > kWindow ? last_difference : edge;
      float beyond = edge > last_edge ? clamp((edge - level) / (edge - last_edge), 0.0, 1.0) : 0.0;
      float index = float(sample_index) - float(kWindow / 2) + 0.5 - beyond;
      surface = crossed ? rays.start + index * rays.step : surface;
      last_difference = edge;

      if (kComposite) {
        float share = clamp((value - rays.transparent) * rays.ramp_scale, 0.0, 1.0) * rays.step_opacity;
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
