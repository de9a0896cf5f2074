// SPDX-License-Identifier: Apache-2.0
// Pass 1, where the weights of pass 2 need it: the confidence of each surface, the contrast of its edge over
// the noise next to it (renderer/ALGORITHM.md, pass 2). Contrast: the difference of the means of kWindow / 2
// samples before and behind the surface. Noise: the root mean square of their standard deviations, at least
// one grey level.
//
// Reads: the parameters; the volume and the angle table (fan_volume.h); ray_depth.
// Writes: confidence, a float for each pixel, 0 without a surface or without samples on one of its sides.
//   Both maps: height x width of the picture.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_control_flow_attributes : require
#include "bindings.h"
#include "cast_parameters.h"

layout(local_size_x = 8, local_size_y = 8) in;

// As in cast.comp.
layout(constant_id = 0) const int kWindow = 8;
layout(constant_id = 2) const int kFrames = FANLIGHT_FRAMES_PARALLEL;
layout(constant_id = 4) const int kAcross = 0;

#define rays parameters[FANLIGHT_PARAMETER_INDEX]
layout(binding = FANLIGHT_BINDING_RAY_DEPTH, scalar) readonly buffer RayDepths {
  float ray_depth[];
};
layout(binding = FANLIGHT_BINDING_CONFIDENCE, scalar) writeonly buffer Confidences {
  float confidence[];
};
#include "fan_volume.h"
#include "ray.h"

// Lower limit of the noise: one grey level.
const float kMinNoise = 1.0 / 255.0;
const int kHalf = kWindow / 2;

// Mean, variance and number of the scanned samples on one side of a surface.
struct Side {
  float mean;
  float variance;
  float count;
};

Side side_of(Ray ray, float at, float spacing) {
  float sum = 0.0;
  float squares = 0.0;
  float count = 0.0;
  for (int index = 0; index < kHalf; ++index) {
    float t = at + (float(index) + 0.5) * spacing;
    vec2 interval = between_frames(vec2(t, t), ray.from, ray.forward);
    float value = interval.x <= interval.y ? sample_at(ray, t) : -1.0;
    float scanned = value >= 0.0 ? 1.0 : 0.0;
    sum += scanned * value;
    squares += scanned * value * value;
    count += scanned;
  }
  float mean = sum / max(count, 1.0);
  return Side(mean, max(squares / max(count, 1.0) - mean * mean, 0.0), count);
}

float confidence_at(Ray ray, float surface) {
  Side near = side_of(ray, surface, -ray.spacing);
  Side far = side_of(ray, surface, ray.spacing);
  float noise = max(sqrt(0.5 * (near.variance + far.variance)), kMinNoise);
  return min(near.count, far.count) > 0.0 ? abs(far.mean - near.mean) / noise : 0.0;
}

void main() {
  uvec2 pixel = gl_GlobalInvocationID.xy;
  if (pixel.x >= rays.width || pixel.y >= rays.height) return;
  uint index = pixel.y * rays.width + pixel.x;
  float surface = ray_depth[index];
  float result = 0.0;
  // A loop, not an `if`: where no lane has a surface, nothing is sampled.
  for (int once = surface >= 0.0 ? 0 : 1; once < 1; ++once)
    result = confidence_at(ray_of(vec2(pixel)), surface);
  confidence[index] = result;
}
