// Pass 1, planes through the volume: each in its part of the picture, through the same tables as the rays.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "cast_parameters.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(constant_id = 2) const bool kPolar = false;

#define rays parameters[FANLIGHT_THE_ONLY]
layout(binding = FANLIGHT_BINDING_VOLUME_COLOUR, scalar) writeonly buffer Colours { uint volume_colour[]; };
#include "fan_volume.h"

void main() {
  uvec2 pixel = gl_GlobalInvocationID.xy;
  if (pixel.x >= rays.width || pixel.y >= rays.height) return;
  for (uint each = 0u; each < rays.slices; ++each) {
    uvec2 in_part = pixel - uvec2(rays.slice_planes[each].left, rays.slice_planes[each].top);
    // A pixel before the part has wrapped to beyond its size.
    if (in_part.x >= rays.slice_planes[each].width || in_part.y >= rays.slice_planes[each].height) continue;
    vec3 at = rays.slice_planes[each].origin + float(pixel.x) * rays.slice_planes[each].right_step +
              float(pixel.y) * rays.slice_planes[each].down_step;
    vec2 part = between_frames(cropped(vec2(0.0, 0.0), at, vec3(0.0)), at, vec3(0.0));
    float value = part.x <= part.y ? max(echo(at), 0.0) : 0.0;
    volume_colour[pixel.y * rays.width + pixel.x] = packUnorm4x8(vec4(vec3(value), 1.0));
  }
}
