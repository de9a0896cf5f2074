// SPDX-License-Identifier: Apache-2.0
// The soft part of the light, for each 2 x 2 pixels: what changes little from pixel to pixel, and costs much
// (renderer/ALGORITHM.md, soft light). Two maps of half the picture's width and height, rounded up, lie one
// behind the other in the memory of pass 3's diffusion, which runs later. The includer has declared the
// parameters as `lighting`.
#ifndef FANLIGHT_SHADERS_SOFT_LIGHT_H
#define FANLIGHT_SHADERS_SOFT_LIGHT_H

struct SoftLight {
  // All three fade where the surface ends and nothing is known beyond.
  float direct;     // share of the direct light that no shadow takes, 0 to 1
  float sky;        // share of the light from everywhere that arrives, 0 to 1
  float scattered;  // light that leaves the surface around, relative to a surface that faces the light
  float depth;      // of the surface, mm; FANLIGHT_NO_SURFACE: none in these pixels
};

ivec2 soft_size() {
  return ivec2(lighting.width + 1u, lighting.height + 1u) / 2;
}

#ifdef FANLIGHT_WEB
uniform highp sampler2D soft_lights;  // of one map, four half floats

SoftLight soft_light_at(ivec2 at, uint map) {
  vec4 values = texelFetch(soft_lights, at, 0);
  return SoftLight(values.x, values.y, values.z, values.w);
}
#else
layout(binding = FANLIGHT_BINDING_DIFFUSED, scalar) buffer SoftLights {
  uvec2 soft_lights[];  // four half floats
};

// `map`: 0 or 1.
uint soft_index(ivec2 at, uint map) {
  ivec2 size = soft_size();
  return map * uint(size.x * size.y) + uint(at.y * size.x + at.x);
}

SoftLight soft_light_at(ivec2 at, uint map) {
  uvec2 halves = soft_lights[soft_index(at, map)];
  vec2 first = unpackHalf2x16(halves.x);
  vec2 second = unpackHalf2x16(halves.y);
  return SoftLight(first.x, first.y, second.x, second.y);
}

void write_soft_light(ivec2 at, uint map, SoftLight light) {
  soft_lights[soft_index(at, map)] =
      uvec2(packHalf2x16(vec2(light.direct, light.sky)), packHalf2x16(vec2(light.scattered, light.depth)));
}
#endif

#endif
