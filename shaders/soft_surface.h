// SPDX-License-Identifier: Apache-2.0
// The soft light of a surface (renderer/ALGORITHM.md, soft light). Shared by soft_light.comp and
// scatter.comp, and by displays that light surfaces themselves (web/soft_light.frag, web/scatter.frag). The
// includer has declared what these expect.
#ifndef FANLIGHT_SHADERS_SOFT_SURFACE_H
#define FANLIGHT_SHADERS_SOFT_SURFACE_H
#include "soft_light.h"
#include "surface_light.h"

// Points around a pixel, on a spiral of equal areas: its angle grows by the golden angle. In radii of the
// neighbourhood: sqrt((i + 0.5) / 12) (cos 2.4 i, sin 2.4 i).
const int kAround = 12;
const vec2 kSpiral[kAround] =
    vec2[](vec2(0.204, 0.0), vec2(-0.261, 0.239), vec2(0.040, -0.455), vec2(0.328, 0.429),
           vec2(-0.603, -0.107), vec2(0.571, -0.363), vec2(-0.190, 0.711), vec2(-0.366, -0.700),
           vec2(0.789, 0.286), vec2(-0.822, 0.335), vec2(0.397, -0.847), vec2(0.285, 0.937));
// A slope towards a point is hidden from the sky above this sine. Below it, rounding would darken planes.
const float kLeastRise = 0.08;
// How much of the sky a neighbourhood of walls hides, relative to the mean over the spiral.
const float kHidden = 3.0;

// Steps through the body, each of a quarter of the distance at which light falls to 1 / e.
const int kSteps = 24;

// Share of the light from everywhere that arrives: 1 on a plane, less in hollows. After McGuire et al., "The
// Alchemy screen-space ambient obscurance algorithm", 2011: points of the neighbourhood above the tangent
// plane hide, the less the farther they are.
float sky_seen(ivec2 pixel, vec3 at, vec3 normal) {
  float radius = lighting.occlusion_reach / (lighting.pixel * view_scale(-at.z));
  float hidden = 0.0;
  [[unroll]] for (int point = 0; point < kAround; ++point) {
    ivec2 there = pixel + ivec2(floor(radius * kSpiral[point] + 0.5));
    float depth_there = depth_at(there);
    vec3 away = point_at(vec2(there), depth_there) - at;
    float apart = max(length(away), 1e-3);
    float near = max(1.0 - dot(away, away) / (lighting.occlusion_reach * lighting.occlusion_reach), 0.0);
    float rise = max(dot(away, normal) / apart - kLeastRise, 0.0);
    hidden += depth_there >= 0.0 ? near * rise : 0.0;
  }
  return clamp(1.0 - kHidden * hidden / float(kAround), 0.0, 1.0);
}

// 1 inside a surface, falling to 0 at a border beyond which none is known. A straight border leaves half of
// the points around with a surface.
float known_around(ivec2 pixel, float depth) {
  float radius = lighting.fade_reach / (lighting.pixel * view_scale(depth));
  float known = 0.0;
  float points = 0.0;
  [[unroll]] for (int point = 0; point < kAround; ++point) {
    ivec2 there = pixel + ivec2(floor(radius * kSpiral[point] + 0.5));
    points += in_view(there) ? 1.0 : 0.0;
    known += depth_at(there) >= 0.0 ? 1.0 : 0.0;
  }
  // In a close-up all points may lie outside the picture.
  return points > 0.0 ? clamp(2.0 * known / points - 1.0, 0.0, 1.0) : 1.0;
}

// Share of a light that comes through the body to a point, 0 to 1. The surface is known from the viewer's
// side only: whatever lies below it is taken for tissue, up to the next step down.
float light_through(vec3 at, vec3 to_light, int steps, int lamp) {
  float step_length = 0.25 * lighting.glow_reach;
  float light_distance = lighting.directional != 0 ? 1e9 : length(lighting.lamp_places[lamp] - at);
  float thickness = 0.0;
  for (int step_number = 0; step_number < steps; ++step_number) {
    float along = (float(step_number) + 0.5) * step_length;
    vec3 there = at + along * to_light;
    bool in_body = along < light_distance && there.z <= lighting.shadow_top;
    there.z = min(there.z, lighting.shadow_top);
    float depth_there = depth_at(ivec2(floor(pixel_of(there) + 0.5)));
    float clearance = there.z + depth_there;
    float inside = depth_there >= 0.0 ? clamp(0.5 - clearance / step_length, 0.0, 1.0) : 0.0;
    thickness += in_body ? inside * step_length : 0.0;
  }
  return exp(-thickness / lighting.glow_reach);
}

// 2 x 2 pixels, of which the first that has a surface stands for all, and what of their light does not depend
// on where the lights are.
struct Place {
  ivec2 pixel;
  float depth;  // mm; FANLIGHT_NO_SURFACE: without a surface, and without the following
  vec3 normal;
  float sky;    // share of the light from everywhere that arrives, 0 to 1
  float known;  // falls to 0 at a border beyond which no surface is known
};

Place place_at(ivec2 at) {
  Place place;
  place.pixel = 2 * at;
  place.depth = FANLIGHT_NO_SURFACE;
  [[unroll]] for (int each = 3; each >= 0; --each) {
    ivec2 candidate = 2 * at + ivec2(each & 1, each >> 1);
    float depth_there = depth_at(candidate);
    place.pixel = depth_there >= 0.0 ? candidate : place.pixel;
    place.depth = depth_there >= 0.0 ? depth_there : place.depth;
  }
  place.normal = vec3(0.0, 0.0, 1.0);
  place.sky = place.known = 1.0;
  if (place.depth < 0.0) return place;
  vec3 point = point_at(vec2(place.pixel), place.depth);
  place.normal = normal_at(place.pixel, place.depth);
  if (lighting.occlusion > 0.0)
    place.sky = mix(1.0, sky_seen(place.pixel, point, place.normal), lighting.occlusion);
  if (lighting.fade_reach > 0.0) place.known = known_around(place.pixel, place.depth);
  return place;
}

SoftLight soft_light_of(Place place) {
  SoftLight soft = SoftLight(vec3(1.0), 1.0, vec3(0.0), FANLIGHT_NO_SURFACE);
  if (place.depth < 0.0) return soft;
  vec3 point = point_at(vec2(place.pixel), place.depth);
  for (int lamp = 0; lamp < lighting.lamps; ++lamp) {
    vec3 to_light = direction_to_light(point, lamp);
    float cosine = dot(place.normal, to_light);
    float direct = direct_light(point, place.depth, cosine, lamp);
    // A side that faces the light is lit from the front or lies in a shadow. The thickness of what throws the
    // shadow is not known, so only a side that faces away is lit through the body.
    bool glows = lighting.glow > 0.0 && cosine <= 0.0;
    float through = glows ? lighting.glow * light_through(point, to_light, glows ? kSteps : 0, lamp) : 0.0;
    soft.direct[lamp] = place.known * direct;
    soft.scattered[lamp] = place.known * abs(cosine) * (cosine > 0.0 ? direct : through);
  }
  soft.sky = place.known * place.sky;
  soft.depth = place.depth;
  return soft;
}

#endif
