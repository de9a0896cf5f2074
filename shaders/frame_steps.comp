// SPDX-License-Identifier: Apache-2.0
// Pass 1, after the rays, where the scene asks for it: the mean of the surface over one distance of frames,
// across the frames (renderer/ALGORITHM.md, pass 1). Between two frames rays read the mixed echoes of both,
// which have two edges where the surface is slanted to the frames. A surface placed by them has steps as long
// as the distance of frames, and the mean over one of them has none.
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
const bool kPolar = false;
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

// Lengths in distances between frames. Depths that differ by more are two surfaces.
const float kMostStep = 4.0;
// The direction across the frames is measured over so much to both sides.
const float kBase = 0.7;
const float kLargestBase = 64.0;  // pixels
// The mean goes over at most so much of the picture.
const float kLongestMean = 3.0;
// Where the frame coordinate changes by less than this over one distance of frames, the surface runs along
// the frames and has no steps.
const float kLeastChange = 0.25;
// Pairs of pixels in the mean, at even distances to both sides.
const int kPairs = 5;

// The nearest pixel of the viewport.
ivec2 in_viewport(ivec2 pixel) {
  ivec2 first = ivec2(rays.view_left, rays.view_top);
  return clamp(pixel, first, first + ivec2(rays.view_width, rays.view_height) - 1);
}

float ray_depth_at(ivec2 pixel) {
  ivec2 inside = in_viewport(pixel);
  return ray_depth[inside.y * int(rays.width) + inside.x];
}

// The frame coordinate of the surface at a pixel: 0 for the first frame, between frames a fraction.
float frame_at_depth(ivec2 pixel, float depth_mm) {
  vec3 at = rays.origin + float(pixel.x) * rays.right_step + float(pixel.y) * rays.down_step +
            depth_mm * (rays.forward + float(pixel.x) * rays.right_turn + float(pixel.y) * rays.down_turn);
  return frame_at(at.z, at.y + rays.motor_radius, from_axis_of(at));
}

// A pixel, the depth and the frame coordinate of the surface there, and the distance of frames there.
struct Place {
  ivec2 pixel;
  float depth;
  float frame;
  float distance_mm;
};

bool same_surface(Place here, float depth_mm) {
  return depth_mm >= 0.0 && abs(depth_mm - here.depth) < kMostStep * here.distance_mm;
}

// The change of the frame coordinate to the pixel `base` away, and 1; zeros where it has another surface.
vec2 change_to(Place here, ivec2 base) {
  ivec2 there = in_viewport(here.pixel + base);
  float depth_mm = ray_depth_at(there);
  return same_surface(here, depth_mm) ? vec2(frame_at_depth(there, depth_mm) - here.frame, 1.0) : vec2(0.0);
}

// The mean change of the frame coordinate along `base`, over the sides of a pixel that have its surface.
float change_along(Place here, ivec2 base) {
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
    // Shifted, since whole() takes no negative numbers.
    ivec2 shift = ivec2(whole(offset.x + 4096.0), whole(offset.y + 4096.0)) - 4096;
    float before = ray_depth_at(here.pixel - shift);
    float after = ray_depth_at(here.pixel + shift);
    bool both = same_surface(here, before) && same_surface(here, after);
    sum += both ? before + after : 0.0;
    count += both ? 2.0 : 0.0;
  }
  return count > 0.0 ? sum / count : here.depth;
}

float without_steps(ivec2 pixel, float depth_mm) {
  Ray ray = ray_of(vec2(pixel));
  float distance_mm = rays.frame_angle * from_axis_of(ray.from + depth_mm * ray.forward);
  Place here = Place(pixel, depth_mm, frame_at_depth(pixel, depth_mm), distance_mm);
  float pixels = distance_mm / length(rays.right_step + depth_mm * rays.right_turn);
  float base = clamp(floor(kBase * pixels + 0.5), 1.0, kLargestBase);
  vec2 change = vec2(change_along(here, ivec2(whole(base), 0)), change_along(here, ivec2(0, whole(base))));
  change /= base;  // for one pixel
  float steepest = length(change);
  float mean_length = min(1.0 / max(steepest, 1e-6), kLongestMean * pixels);
  float mean_mm = mean_along(here, mean_length / max(steepest, 1e-6) * change);
  vec2 shown = cropped(vec2(rays.start, rays.end), ray.from, ray.forward);
  return steepest * pixels > kLeastChange ? clamp(mean_mm, shown.x, max(shown.x, shown.y)) : depth_mm;
}

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (pixel.x >= int(rays.width) || pixel.y >= int(rays.height)) return;
  int index = pixel.y * int(rays.width) + pixel.x;
  float found = ray_depth[index];
  float result = found;
  // A loop, not an `if`: where no lane has a surface, nothing is read.
  for (int once = found >= 0.0 ? 0 : 1; once < 1; ++once) result = without_steps(pixel, found);
  depth[index] = result;
}
