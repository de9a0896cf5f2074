// SPDX-License-Identifier: Apache-2.0
// The soft part of the light, for each 2 x 2 pixels: what changes little from pixel to pixel, and costs much
// (renderer/ALGORITHM.md, soft light). Three maps of half the picture's width and height, rounded up, lie one
// behind the other in the memory of pass 3's diffusion, which runs later: direct and sky; scattered and
// depth; and the latter after the rows. They fit from 7 x 7 pixels on. The includer has declared the
// parameters as `lighting`.
#ifndef FANLIGHT_SHADERS_SOFT_LIGHT_H
#define FANLIGHT_SHADERS_SOFT_LIGHT_H

// A vector has one component for each light that is on. Both fade where the surface ends and nothing is known
// beyond, and so does `sky`.
struct SoftLight {
  vec3 direct;     // share of the direct light that no shadow takes, 0 to 1
  float sky;       // share of the ambient light that arrives, 0 to 1
  vec3 scattered;  // light that leaves the surface around, relative to a surface that faces the light
  float depth;     // of the surface, mm; FANLIGHT_NO_SURFACE: none in these pixels
};

ivec2 soft_size() {
  return ivec2(lighting.width + 1u, lighting.height + 1u) / 2;
}

#ifdef FANLIGHT_WEB
uniform highp sampler2D soft_direct;     // direct, sky
uniform highp sampler2D soft_scattered;  // scattered, depth

vec4 scattered_at(ivec2 at, uint map) {
  return texelFetch(soft_scattered, at, 0);
}

SoftLight soft_light_at(ivec2 at) {
  vec4 first = texelFetch(soft_direct, at, 0);
  vec4 second = texelFetch(soft_scattered, at, 0);
  return SoftLight(first.xyz, first.w, second.xyz, second.w);
}
#else
layout(binding = FANLIGHT_BINDING_DIFFUSED, scalar) buffer SoftLights {
  uvec2 soft_lights[];  // four half floats
};

// `map`: 0 to 2.
uint soft_index(ivec2 at, uint map) {
  ivec2 size = soft_size();
  return map * uint(size.x * size.y) + uint(at.y * size.x + at.x);
}

vec4 soft_values(ivec2 at, uint map) {
  uvec2 halves = soft_lights[soft_index(at, map)];
  return vec4(unpackHalf2x16(halves.x), unpackHalf2x16(halves.y));
}

void write_soft_values(ivec2 at, uint map, vec4 values) {
  soft_lights[soft_index(at, map)] = uvec2(packHalf2x16(values.xy), packHalf2x16(values.zw));
}

// Scattered and depth. `map`: 1 or 2.
vec4 scattered_at(ivec2 at, uint map) {
  return soft_values(at, map);
}

SoftLight soft_light_at(ivec2 at) {
  vec4 first = soft_values(at, 0u);
  vec4 second = soft_values(at, 1u);
  return SoftLight(first.xyz, first.w, second.xyz, second.w);
}

void write_soft_light(ivec2 at, SoftLight light) {
  write_soft_values(at, 0u, vec4(light.direct, light.sky));
  write_soft_values(at, 1u, vec4(light.scattered, light.depth));
}
#endif

#endif
