// SPDX-License-Identifier: Apache-2.0
// Pass 1, after the rays, where the scene asks for it: the mean of the surface over one frame spacing, across
// the frames (renderer/ALGORITHM.md, pass 1). Between two frames rays read the mixed echoes of both,
// which have two edges where the surface is slanted to the frames. A surface placed by them has steps as long
// as the frame spacing, and the mean over one spacing has none.
//
// Reads: the parameters; the angle table; ray_depth.
// Writes: depth. Both: float a pixel, mm, height x width of the picture.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_control_flow_attributes : require
#include "bindings.h"
#include "cast_parameters.h"

layout(local_size_x = 8, local_size_y = 8) in;

// Of ray.h and fan_volume.h, which sample nothing here.
const int kFrames = FANLIGHT_FRAMES_PARALLEL;
const int kAcross = 0;

#define rays parameters[FANLIGHT_PARAMETER_INDEX]
layout(binding = FANLIGHT_BINDING_RAY_DEPTH, scalar) readonly buffer RayDepths {
  float ray_depth[];
};
layout(binding = FANLIGHT_BINDING_DEPTH, scalar) writeonly buffer DepthMap {
  float depth[];
};
#include "fan_volume.h"
#include "ray.h"

// In frame spacings. Depths that differ by more are two surfaces.
const float kMostStep = 4.0;
// The direction across the frames is measured over so much to both sides.
const float kBase = 0.7;
// The mean goes over at most so much of the picture.
const float kLongestMean = 3.0;
// Where the frame coordinate changes by less than the first over one frame spacing, the surface runs along
// the frames and has no steps; from the second on the mean counts in full.
const float kLeastChange = 0.25;
const float kFullChange = 0.4;
// Pairs of pixels in the mean, at even distances to both sides.
const int kPairs = 5;
const float kFarAway = 8192.0;  // pixels, beyond any picture

// The depth of the surface at a pixel; negative where there is none, and outside the viewport.
float surface_at(vec2 pixel) {
  vec2 first = vec2(ivec2(rays.view_left, rays.view_top));
  vec2 last = first + vec2(ivec2(rays.view_width, rays.view_height)) - 1.0;
  vec2 inside = clamp(pixel, first, last);
  float found = ray_depth[whole(inside.y) * int(rays.width) + whole(inside.x)];
  return all(equal(inside, pixel)) ? found : FANLIGHT_NO_SURFACE;
}

// The frame coordinate of the surface at a pixel: 0 for the first frame, between frames a fraction.
float frame_at_depth(vec2 pixel, float depth_mm) {
  Ray ray = ray_of(pixel);
  vec3 at = ray.from + depth_mm * ray.forward;
  return frame_at(at.z, at.y + rays.motor_radius, from_axis_of(at));
}

// A pixel, the depth and the frame coordinate of the surface there, and the frame spacing there.
struct Place {
  vec2 pixel;
  float depth;
  float frame;
  float spacing_mm;
};

bool same_surface(Place here, float depth_mm) {
  return depth_mm >= 0.0 && abs(depth_mm - here.depth) < kMostStep * here.spacing_mm;
}

// The change of the frame coordinate to the pixel `base` away, and 1; zeros where it has not this surface.
vec2 change_to(Place here, vec2 base) {
  vec2 pixel = here.pixel + base;
  float depth_mm = surface_at(pixel);
  return same_surface(here, depth_mm) ? vec2(frame_at_depth(pixel, depth_mm) - here.frame, 1.0) : vec2(0.0);
}

// The mean change of the frame coordinate along `base`, over the sides of a pixel that have its surface.
float change_along(Place here, vec2 base) {
  vec2 ahead = change_to(here, base);
  vec2 back = change_to(here, -base);
  return (ahead.x - back.x) / max(ahead.y + back.y, 1.0);
}

// The mean of the depths along `direction`, pixels, from half its length before the pixel to half behind it.
// Pairs keep the mean of a slanted plane at the pixel.
float mean_along(Place here, vec2 direction) {
  float sum = 0.0;
  float count = 0.0;
  [[dont_unroll]] for (int pair = 0; pair < kPairs; ++pair) {
    vec2 offset = floor((float(pair) + 0.5) * (0.5 / float(kPairs)) * direction + 0.5);
    float before = surface_at(here.pixel - offset);
    float after = surface_at(here.pixel + offset);
    bool both = same_surface(here, before) && same_surface(here, after);
    sum += both ? before + after : 0.0;
    count += both ? 2.0 : 0.0;
  }
  return count > 0.0 ? sum / count : here.depth;
}

float without_steps(vec2 pixel, float depth_mm) {
  Ray ray = ray_of(pixel);
  float spacing_mm = rays.frame_angle * from_axis_of(ray.from + depth_mm * ray.forward);
  Place here = Place(pixel, depth_mm, frame_at_depth(pixel, depth_mm), spacing_mm);
  float pixels = spacing_mm / length(rays.right_step + depth_mm * rays.right_turn);
  float base = clamp(floor(kBase * pixels + 0.5), 1.0, kFarAway);
  vec2 change = vec2(change_along(here, vec2(base, 0.0)), change_along(here, vec2(0.0, base))) / base;
  float steepest = length(change);  // for one pixel
  float mean_length = min(1.0 / max(steepest, 1e-6), kLongestMean * pixels);
  float mean_mm = mean_along(here, mean_length / max(steepest, 1e-6) * change);
  float share = clamp((steepest * pixels - kLeastChange) / (kFullChange - kLeastChange), 0.0, 1.0);
  vec2 shown = cropped(vec2(rays.start, rays.end), ray.from, ray.forward);
  // With one ray for several pixels, a pixel may show a surface that its own ray does not meet.
  return shown.x <= shown.y ? clamp(mix(depth_mm, mean_mm, share), shown.x, shown.y) : depth_mm;
}

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (pixel.x >= int(rays.width) || pixel.y >= int(rays.height)) return;
  int index = pixel.y * int(rays.width) + pixel.x;
  float found = ray_depth[index];
  float result = found;
  // A loop, not an `if`: where no lane has a surface, nothing is read.
  for (int once = found >= 0.0 ? 0 : 1; once < 1; ++once) result = without_steps(vec2(pixel), found);
  depth[index] = result;
}
