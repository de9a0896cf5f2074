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
#include "certainty.h"
#include "light_parameters.h"
#include "map_totals.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(constant_id = 0) const bool kPerspective = false;
// The light has a radius.
layout(constant_id = 1) const bool kSoftShadows = true;
// Shadows and scattered light come from soft_light.comp and scatter.comp.
layout(constant_id = 2) const bool kSoftLight = false;

layout(binding = FANLIGHT_BINDING_VOLUME_COLOUR, scalar) readonly buffer Colours {
  uint volume_colour[];
};
layout(binding = FANLIGHT_BINDING_SMOOTH_DEPTH, scalar) readonly buffer Smooth {
  float smooth_depth[];
};
layout(binding = FANLIGHT_BINDING_MAP_TOTALS, scalar) readonly buffer Totals {
  MapTotals totals;
};
layout(binding = FANLIGHT_BINDING_LIT, scalar) writeonly buffer Lit {
  uvec2 lit[];
};
#include "lit_picture.h"
#include "soft_light.h"
#include "surface_light.h"

// Share of the light that a surface without any certainty has.
const float kUncertainLight = 0.3;
// The light that the film tone shows as white.
const float kWhite = 3.0;

// The soft light at a pixel: between the up to four places around it on the same surface.
SoftLight soft_light_around(ivec2 pixel, float depth) {
  ivec2 first = pixel / 2;
  vec2 part = 0.5 * vec2(pixel - 2 * first);
  vec3 sum = vec3(0.0);
  float weights = 0.0;
  [[unroll]] for (int each = 0; each < 4; ++each) {
    ivec2 step = ivec2(each & 1, each >> 1);
    SoftLight there = soft_light_at(min(first + step, soft_size() - 1), 0u);
    float alike = max(1.0 - abs(there.depth - depth) / lighting.same_surface, 0.001);
    vec2 share = mix(1.0 - part, part, vec2(step));
    float weight = there.depth >= 0.0 ? share.x * share.y * alike : 0.0;
    sum += weight * vec3(there.direct, there.sky, there.scattered);
    weights += weight;
  }
  vec3 mean = weights > 0.0 ? sum / weights : vec3(1.0, 1.0, 0.0);
  return SoftLight(mean.x, mean.y, mean.z, depth);
}

// How certain the surface is: the mean of the rays about a pixel, since speckle makes it uneven. 0 where none
// of them met a surface: the pixel is in a hole that was filled.
float certainty_about(ivec2 pixel) {
  ivec2 first = ivec2(lighting.view_left, lighting.view_top);
  ivec2 last = ivec2(lighting.view_right, lighting.view_bottom);
  float sum = 0.0;
  float met = 0.0;
  [[unroll]] for (int each = 0; each < 9; ++each) {
    ivec2 beside = ivec2(each % 3, each / 3) - 1;
    uint colour = volume_colour[index_of(clamp(pixel + beside, first, last))];
    sum += certainty_of(colour);
    met += has_surface(colour) ? 1.0 : 0.0;
  }
  return sum / max(met, 1.0);
}

vec3 shade(ivec2 pixel, float depth) {
  vec3 at = point_at(vec2(pixel), depth);
  vec3 normal = normal_at(pixel, depth);
  vec3 to_light = direction_to_light(at);
  // Parallel rays: the viewer is at infinity.
  vec3 to_eye = kPerspective ? normalize(vec3(0.0, 0.0, lighting.eye_height) - at) : vec3(0.0, 0.0, 1.0);
  vec3 halfway = normalize(to_light + to_eye);
  float facing = max(dot(normal, to_light), 0.0);
  float highlight = facing > 0.0 ? pow(max(dot(normal, halfway), 0.0), lighting.shininess) : 0.0;
  SoftLight soft = SoftLight(1.0, 1.0, 0.0, depth);
  if (kSoftLight) {
    soft = soft_light_around(pixel, depth);
  } else {
    soft.direct = direct_light(at, depth, facing);
  }
  vec3 matt = mix(vec3(facing * soft.direct), vec3(soft.scattered), lighting.scattered);
  float away = 1.0 - max(dot(normal, to_eye), 0.0);
  float rim = lighting.rim * away * away * away;
  // A shadow reduces the direct light only. The paper (README.md) scales the whole pixel. Then a side that
  // faces away from the light, with ambient light only, is brighter than a shadow next to it.
  vec3 from_body = ((lighting.ambient + rim) * soft.sky + lighting.diffuse * matt) * lighting.material;
  vec3 light = lighting.light_colour * (from_body + vec3(lighting.specular * highlight * soft.direct));
  return mix(kUncertainLight, 1.0, certainty_about(pixel)) * light;
}

// Light to what a screen can show. Reinhard et al., "Photographic tone reproduction for digital images",
// 2002, equation 4, for each component: bright light is compressed, up to kWhite, which is shown as white.
vec3 toned(vec3 light) {
  vec3 exposed = lighting.exposure * light;
  vec3 film = exposed * (1.0 + exposed / (kWhite * kWhite)) / (1.0 + exposed);
  return lighting.film != 0 ? film : exposed;
}

// Linear to displayed (sRGB).
vec3 encoded(vec3 linear) {
  vec3 bounded = clamp(linear, 0.0, 1.0);
  vec3 curve = 1.055 * pow(bounded, vec3(1.0 / 2.4)) - 0.055;
  return mix(curve, 12.92 * bounded, lessThan(bounded, vec3(0.0031308)));
}

vec3 colour_at(ivec2 pixel) {
  return unpackUnorm4x8(volume_colour[index_of(pixel)]).rgb;
}

vec3 shown_at(ivec2 pixel) {
  if (!in_view(pixel)) {
    // Beside the surface: the planes, or the colours of the volume from the pixels that have rays.
    ivec2 from = pixel - ivec2(lighting.colours_from_left, 0);
    bool beyond = lighting.colours_from_left > 0 && (from.x < 0 || !in_view(from));
    return beyond ? vec3(0.0) : colour_at(from);
  }
  if (lighting.show == FANLIGHT_SHOW_COLOUR) return colour_at(pixel);
  float depth = smooth_depth[index_of(pixel)];
  if (depth < 0.0) return vec3(0.0);
  if (lighting.show == FANLIGHT_SHOW_DEPTH) {
    return vec3(clamp(1.0 - (depth - lighting.depth_white) * lighting.depth_scale, 0.0, 1.0));
  }
  return encoded(toned(shade(pixel, depth)));
}

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (pixel.x >= int(lighting.width) || pixel.y >= int(lighting.height)) return;
  vec3 colour = shown_at(pixel);
  lit[index_of(pixel)] = packed(colour);
}
