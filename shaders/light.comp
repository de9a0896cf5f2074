// SPDX-License-Identifier: Apache-2.0
// Pass 2, light: shades the filtered depth map (renderer/ALGORITHM.md, pass 2): normals, Blinn-Phong, and a
// shadow ray over the height map. Or shows the depth map or the colours of pass 1.
//
// Reads: the parameters; smooth_depth, float a pixel, mm; volume_colour, RGBA8 a pixel, with the certainty
//   (certainty.h); totals (map_totals.comp).
// Writes: lit, four half floats a pixel, displayed (sRGB) values. Maps: height x width of the picture.
//
// Points are in the view frame, mm: right, up, and height towards the viewer (-depth).
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_control_flow_attributes : require
#include "bindings.h"
#include "light_parameters.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(constant_id = 0) const bool kPerspective = false;
// The light has a radius. Without effect where kSoftLight is true.
layout(constant_id = 1) const bool kSoftShadows = true;
// Shadows and scattered light come from soft_light.comp and scatter.comp.
layout(constant_id = 2) const bool kSoftLight = false;

layout(binding = FANLIGHT_BINDING_VOLUME_COLOUR, scalar) readonly buffer Colours {
  uint volume_colour[];
};
layout(binding = FANLIGHT_BINDING_LIT, scalar) writeonly buffer Lit {
  uvec2 lit[];
};
#include "filtered_map.h"
#include "lit_picture.h"

uint pass1_colour(ivec2 pixel) {
  return volume_colour[index_of(pixel)];
}
#include "mean_certainty.h"
#include "surface_light.h"

vec3 surface_normal(ivec2 pixel, float depth) {
  return normal_at(pixel, depth);
}

float surface_certainty(ivec2 pixel) {
  return certainty_about(pixel);
}
vec3 pass1_layers(ivec2 pixel) {
  return unpackUnorm4x8(pass1_colour(pixel)).rgb;
}
#include "surface_shade.h"

vec3 colour_at(ivec2 pixel) {
  return unpackUnorm4x8(pass1_colour(pixel)).rgb;
}

vec3 shown_at(ivec2 pixel) {
  if (!in_view(pixel)) {
    // Beside the surface: the planes, or the colours of the volume from the pixels that have rays.
    ivec2 from = pixel - ivec2(lighting.colours_from_left, 0);
    bool beyond = lighting.colours_from_left > 0 && (from.x < 0 || !in_view(from));
    return beyond ? vec3(0.0) : colour_at(from);
  }
  if (lighting.show == FANLIGHT_SHOW_COLOUR) return colour_at(pixel);
  return shown_surface(pixel);
}

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (pixel.x >= int(lighting.width) || pixel.y >= int(lighting.height)) return;
  vec3 colour = shown_at(pixel);
  lit[index_of(pixel)] = packed(colour);
}
