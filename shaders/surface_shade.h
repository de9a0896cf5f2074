// SPDX-License-Identifier: Apache-2.0
// The colour of a surface under the light (renderer/ALGORITHM.md, light). Shared by light.comp and by
// displays that light surfaces themselves (web/light.frag). The includer has declared what surface_light.h
// and soft_light.h expect, the constant kSoftLight, and
//   vec3 surface_normal(ivec2 pixel, float depth)   normal_at(), or what was kept of it
//   float surface_certainty(ivec2 pixel)            certainty_about(), or what was kept of it
//   vec3 pass1_layers(ivec2 pixel)                  glass.h; not in web/, where a surface is never glass
#ifndef FANLIGHT_SHADERS_SURFACE_SHADE_H
#define FANLIGHT_SHADERS_SURFACE_SHADE_H
#ifndef FANLIGHT_WEB
#include "glass.h"
#endif
#include "soft_light.h"
#include "surface_light.h"

// Share of the light that a surface without any certainty has.
const float kUncertainLight = 0.3;
// How much faster or slower red, green and blue fall off with the distance: far tissue is darker and cooler.
const vec3 kFalling = vec3(1.15, 1.0, 0.85);
// The light that the film tone shows as white.
const float kWhite = 3.0;

// The soft light at a pixel: between the up to four places around it on the same surface.
SoftLight soft_light_around(ivec2 pixel, float depth) {
  ivec2 first = pixel / 2;
  vec2 part = 0.5 * vec2(pixel - 2 * first);
  vec3 direct = vec3(0.0);
  vec3 scattered = vec3(0.0);
  float sky = 0.0;
  float weights = 0.0;
  [[unroll]] for (int each = 0; each < 4; ++each) {
    ivec2 step = ivec2(each & 1, each >> 1);
    SoftLight there = soft_light_at(min(first + step, soft_size() - 1));
    float alike = max(1.0 - abs(there.depth - depth) / lighting.same_surface, 0.001);
    vec2 share = mix(1.0 - part, part, vec2(step));
    float weight = there.depth >= 0.0 ? share.x * share.y * alike : 0.0;
    direct += weight * there.direct;
    scattered += weight * there.scattered;
    sky += weight * there.sky;
    weights += weight;
  }
  bool known = weights > 0.0;
  float each = known ? 1.0 / weights : 0.0;
  return SoftLight(known ? each * direct : vec3(1.0), known ? each * sky : 1.0, each * scattered, depth);
}

vec3 shade(ivec2 pixel, float depth) {
  vec3 at = point_at(vec2(pixel), depth);
  vec3 normal = surface_normal(pixel, depth);
  // Parallel rays: the viewer is at infinity.
  vec3 to_eye = kPerspective ? normalize(vec3(0.0, 0.0, lighting.eye_height) - at) : vec3(0.0, 0.0, 1.0);
  SoftLight soft = SoftLight(vec3(1.0), 1.0, vec3(0.0), depth);
  if (kSoftLight) soft = soft_light_around(pixel, depth);
  vec3 matt = vec3(0.0);
  vec3 shine = vec3(0.0);
  for (int lamp = 0; lamp < lighting.lamps; ++lamp) {
    vec3 to_light = direction_to_light(at, lamp);
    vec3 halfway = normalize(to_light + to_eye);
    float facing = max(dot(normal, to_light), 0.0);
    float highlight = facing > 0.0 ? pow(max(dot(normal, halfway), 0.0), lighting.shininess) : 0.0;
    float direct = kSoftLight ? soft.direct[lamp] : direct_light(at, depth, facing, lamp);
    // Glass throws no shadow, and light does not spread under its surface.
    direct = mix(direct, 1.0, lighting.glass);
    vec3 spread = (1.0 - lighting.glass) * lighting.scattered;
    vec3 entered = mix(vec3(facing * direct), vec3(soft.scattered[lamp]), spread);
    matt += lighting.lamp_colours[lamp] * entered;
    shine += lighting.lamp_colours[lamp] * highlight * direct;
  }
  float away = 1.0 - max(dot(normal, to_eye), 0.0);
  float rim = lighting.rim * away * away * away;
  // A shadow reduces the direct light only. The paper (README.md) scales the whole pixel. Then a side that
  // faces away from the light, with ambient light only, is brighter than a shadow next to it.
  vec3 everywhere = (lighting.ambient + rim) * soft.sky * lighting.light_colour;
  vec3 light = (everywhere + lighting.diffuse * matt) * lighting.material + lighting.specular * shine;
  float halves = max(depth - lighting.half_from, 0.0) * lighting.halves_per_mm;
  light *= mix(kUncertainLight, 1.0, surface_certainty(pixel));
#ifndef FANLIGHT_WEB
  for (bool due = lighting.glass > 0.0; due; due = false) {
    vec3 behind = layers_light(layers_about(pixel), at) * lighting.material;
    light = mix(1.0, kGlassGain, lighting.glass) * mix(behind, light, glass_opacity(1.0 - away));
  }
#endif
  return max(light * exp2(-halves * kFalling), lighting.haze);
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

vec3 shown_surface(ivec2 pixel) {
  float depth = filtered_depth(pixel);
  if (lighting.show == FANLIGHT_SHOW_DEPTH) {
    if (depth < 0.0) return vec3(0.0);
    return vec3(clamp(1.0 - (depth - lighting.depth_white) * lighting.depth_scale, 0.0, 1.0));
  }
  return encoded(toned(depth < 0.0 ? lighting.haze : shade(pixel, depth)));
}

#endif
