// SPDX-License-Identifier: Apache-2.0
// Points, normals and shadow rays of the filtered depth map (renderer/ALGORITHM.md, light). The includer has
// declared the parameters as `lighting`, the constants kPerspective and kSoftShadows, and
//   float filtered_depth(ivec2 pixel)   of a pixel in the viewport, mm; FANLIGHT_NO_SURFACE
//   float nearest_depth()               the smallest one
//
// Points are in the view frame, mm: right, up, and height towards the viewer (-depth).
#ifndef FANLIGHT_SHADERS_SURFACE_LIGHT_H
#define FANLIGHT_SHADERS_SURFACE_LIGHT_H
#include "surface_map.h"

// Height of the start of a shadow ray above the surface, in pixels. Without it a slope casts shadows on
// itself.
const float kShadowBias = 1.5;
// Length of a shadow ray towards a directional light, mm.
const float kShadowReach = 1000.0;

// FANLIGHT_NO_SURFACE outside the viewport.
float depth_at(ivec2 pixel) {
  ivec2 first = ivec2(lighting.view_left, lighting.view_top);
  float depth_there = filtered_depth(clamp(pixel, first, ivec2(lighting.view_right, lighting.view_bottom)));
  return in_view(pixel) ? depth_there : FANLIGHT_NO_SURFACE;
}

// Length across the view at a depth, relative to the depth at which pixels are measured.
float view_scale(float depth) {
  return kPerspective ? lighting.view_scale_at_0 + lighting.view_scale_per_mm * depth : 1.0;
}

// The point of a pixel at a depth. The view frame is right-handed.
vec3 point_at(vec2 pixel, float depth) {
  vec2 across = (pixel - lighting.centre) * lighting.pixel * view_scale(depth);
  return vec3(across.x, -across.y, -depth);
}

// The inverse: the pixel at which a point is seen.
vec2 pixel_of(vec3 at) {
  float scale = lighting.pixel * view_scale(-at.z);
  return lighting.centre + vec2(at.x, -at.y) / scale;
}

// The tangent of the surface along one axis of the picture: the difference between both neighbours, or
// between the pixel and the one neighbour that has a surface. Without one it is parallel to the view plane.
vec3 tangent(ivec2 pixel, ivec2 axis, float here) {
  float next = depth_at(pixel + axis);
  float before = depth_at(pixel - axis);
  bool central = lighting.central_normals != 0;
  bool has_next = central ? same_surface(next, here) : next >= 0.0;
  bool has_before = central ? same_surface(before, here) : before >= 0.0;
  vec3 at = point_at(vec2(pixel), here);
  vec3 from = has_before && (central || !has_next) ? point_at(vec2(pixel - axis), before) : at;
  vec3 to = has_next     ? point_at(vec2(pixel + axis), next)
            : has_before ? at
                         : point_at(vec2(pixel + axis), here);
  return to - from;
}

// Fraction of a light visible from a point of the height map, 0 to 1. Marches one pixel a step and stops at
// the light, at the border of the viewport, or above the highest surface.
float light_seen(vec3 from, float depth, int lamp) {
  vec3 towards_light = lighting.directional != 0 ? kShadowReach * lighting.lamp_directions[lamp]
                                                 : lighting.lamp_places[lamp] - from;
  float light_distance =
      lighting.directional != 0 ? lighting.lamp_distances[lamp] : max(length(towards_light), 1e-3);
  vec3 start = from + vec3(0.0, 0.0, kShadowBias * lighting.pixel * view_scale(depth));
  bool leaves = start.z + towards_light.z > lighting.shadow_top;
  if (lighting.shadow >= 1.0 || (leaves && start.z >= lighting.shadow_top)) return 1.0;
  float part = leaves ? (lighting.shadow_top - start.z) / towards_light.z : 1.0;
  // Above the highest surface nothing hides the light, if the ray climbs faster than its penumbra widens.
  float climb = towards_light.z - lighting.softness * length(towards_light) / light_distance;
  float to_nearest = -nearest_depth() - start.z;
  if (climb > 0.0) part = min(part, max(to_nearest / climb, 0.0));
  vec3 end = start + part * towards_light;

  vec2 start_pixel = pixel_of(start);
  vec2 across = pixel_of(end) - start_pixel;
  float pixels = max(abs(across.x), abs(across.y));
  float start_scale = view_scale(-start.z);
  float end_scale = view_scale(-end.z);
  float ray_length = length(end - start);
  vec2 first = vec2(lighting.view_left, lighting.view_top);
  vec2 last = vec2(lighting.view_right, lighting.view_bottom);

  float step_fraction = 1.0 / pixels;
  // Half width of the penumbra at the end of the ray.
  float blur = lighting.softness * ray_length / light_distance;
  float seen = 1.0;
  for (float pixel_step = 1.0; pixel_step < pixels && seen > 0.0; pixel_step += 1.0) {
    float fraction = pixel_step * step_fraction;
    vec2 at = start_pixel + fraction * across;
    if (any(lessThan(at, first)) || any(greaterThan(at, last))) break;
    // In perspective, equal steps in the picture are not equal steps in the body.
    float along = kPerspective
                      ? fraction * start_scale / (fraction * start_scale + (1.0 - fraction) * end_scale)
                      : fraction;
    float height = mix(start.z, end.z, along);
    float depth_there = filtered_depth(ivec2(at + 0.5));
    float clearance = depth_there >= 0.0 ? height + depth_there : 1e9;
    float visible = kSoftShadows ? clamp(0.5 + 0.5 * clearance / (blur * along), 0.0, 1.0)
                                 : (clearance < 0.0 ? 0.0 : 1.0);
    seen = min(seen, visible);
  }
  return seen;
}

// The normal of the surface at a pixel, length 1, towards the viewer.
vec3 normal_at(ivec2 pixel, float depth) {
  // Rows are numbered downwards.
  return normalize(cross(tangent(pixel, ivec2(1, 0), depth), -tangent(pixel, ivec2(0, 1), depth)));
}

// From a point towards a light, length 1. The light may lie on the surface.
vec3 direction_to_light(vec3 at, int lamp) {
  vec3 toward = lighting.lamp_places[lamp] - at;
  return lighting.directional != 0 ? lighting.lamp_directions[lamp] : toward / max(length(toward), 1e-6);
}

// Fraction of the direct light on a surface that faces the light, 0 to 1: what a shadow leaves of it.
float direct_light(vec3 at, float depth, float facing, int lamp) {
  return facing > 0.0 ? mix(lighting.shadow, 1.0, light_seen(at, depth, lamp)) : 1.0;
}

#endif
