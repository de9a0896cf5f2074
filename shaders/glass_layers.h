// SPDX-License-Identifier: Apache-2.0
// The edges behind the surface, for a surface as glass (renderer/ALGORITHM.md, layers). The includer has
// included fan_volume.h, and declared what edge_detector.h, ray.h and ray_accumulator.h expect.
//
// Front to back, with opacity a and outward normal n of an edge: A += (1 - A) a, N += (1 - A) a n.
#ifndef FANLIGHT_SHADERS_GLASS_LAYERS_H
#define FANLIGHT_SHADERS_GLASS_LAYERS_H
#include "edge_detector.h"
#include "ray.h"
#include "ray_accumulator.h"

// Opacity of an edge that the ray meets at a right angle, as a share of that of one that it grazes.
const float kFaceOn = 0.03;

// Distance from an edge to the samples that give its direction, in samples: a quarter of the detector's
// window.
const int kGradientReach = kHalf >= 4 ? kHalf / 2 : 1;

// Samples behind a surface's edge in which its own edge lies: a first crossing is found before the peak.
const int kOwnLayer = kPlace == FANLIGHT_PLACE_FIRST_CROSSING ? kHalf : 1;

// One of seven directions: the axes (right, up, along the ray), and the diagonals of a cube.
vec3 way_of(int number) {
  vec3 axis = vec3(number == 0, number == 1, number == 2);
  vec3 diagonal = vec3(1.0, number < 5 ? 1.0 : -1.0, number % 2 == 1 ? 1.0 : -1.0);
  return number < 3 ? axis : diagonal;
}

// In proportion to the growth of the echo about a point: to the right, upwards and along the ray. Axes alone
// would tilt a sharp edge, since each of their differences is its whole height as soon as both samples are
// beyond it.
vec3 growth_at(Ray ray, vec3 at) {
  float reach = float(kGradientReach);
  vec3 right = reach * ray.across_right;
  vec3 up = reach * ray.across_up;
  vec3 along = reach * ray.spacing * ray.forward;
  vec3 growth = vec3(0.0);
  [[dont_unroll]] for (int number = 0; number < 7; ++number) {
    vec3 way = way_of(number);
    vec3 beside = way.x * right + way.y * up + way.z * along;
    float before = echo_if_scanned(at - beside);
    float after = echo_if_scanned(at + beside);
    // A direction in which nothing was scanned on one side does not count.
    float rise = before >= 0.0 && after >= 0.0 ? after - before : 0.0;
    growth += (number < 3 ? 2.0 : 1.0) * rise * way;
  }
  return growth;
}

// Adds the edge at depth `t`, mm. `height`: of the detector's step at it.
void add_layer(inout RayAccumulator accumulator, Ray ray, float t, float height, float level) {
  vec3 growth = growth_at(ray, ray.from + t * ray.forward);
  float size = length(growth);
  vec3 normal = -growth / max(size, 1e-6);
  float grazing = size > 0.0 ? 1.0 - abs(normal.z) : 0.0;
  float strength = clamp(height / max(level, 1e-6) - 1.0, 0.0, 1.0);
  float share = (1.0 - accumulator.opacity) * strength * mix(kFaceOn, 1.0, grazing * grazing * grazing);
  accumulator.opacity += share;
  accumulator.colour.xy += share * normal.xy;
}

#endif
