// SPDX-License-Identifier: Apache-2.0
// The ray of a pixel and its samples (renderer/ALGORITHM.md, pass 1). The includer has included
// fan_volume.h, and declared the specialisation constant kAcross: a sample is a mean across the ray, of
// 3 kAcross points.
#ifndef FANLIGHT_SHADERS_RAY_H
#define FANLIGHT_SHADERS_RAY_H

// Transducer frame, mm. The point at depth t below the view plane is from + t * forward.
struct Ray {
  vec3 from;      // in the view plane
  vec3 forward;   // to the point one mm deeper
  float spacing;  // mm of depth between samples
  // Steps of the window across the ray.
  vec3 across_right;
  vec3 across_up;
};

Ray ray_of(vec2 pixel) {
  Ray ray;
  ray.from = rays.origin + pixel.x * rays.right_step + pixel.y * rays.down_step;
  ray.forward = rays.forward + pixel.x * rays.right_turn + pixel.y * rays.down_turn;
  float stride = length(ray.forward);  // mm of ray for each mm of depth
  ray.spacing = rays.step / stride;
  ray.across_right =
      rays.step * normalize(rays.right - dot(rays.right, ray.forward) / (stride * stride) * ray.forward);
  ray.across_up = cross(ray.across_right, ray.forward) / stride;
  return ray;
}

// Rounds a sample to a multiple of 2^-19. Sums of samples in floats are then exact in any order, and the
// sample at which a ray begins does not change its result.
float exact(float value) {
  return floor(value * 524288.0 + 0.5) * (1.0 / 524288.0);
}

// The echo at any point, 0 to 1; negative where nothing was scanned. Rays are cut to the frames, but points
// beside them are not.
float echo_if_scanned(vec3 at) {
  vec2 part = between_frames(vec2(0.0, 0.0), at, vec3(0.0));
  return part.x <= part.y ? echo(at) : -1.0;
}

// The sample at depth t: 0 to 1, negative where nothing was scanned. With a window across the ray, the mean
// of those of its points that were scanned, where the ray itself is within the frames; see
// CastParameters::across_points.
float sample_at(Ray ray, float t) {
  vec3 at = ray.from + t * ray.forward;
  if (kAcross == 0) return exact(echo(at));
  float sum = 0.0;
  float count = 0.0;
  [[dont_unroll]] for (int number = 0; number < FANLIGHT_ACROSS_POINTS * kAcross; ++number) {
    vec2 aside =
        parameters[FANLIGHT_PARAMETER_INDEX].across_points[number];  // `rays` may be a copy in registers
    float value = echo_if_scanned(at + aside.x * ray.across_right + aside.y * ray.across_up);
    sum += max(value, 0.0);
    count += value >= 0.0 ? 1.0 : 0.0;
  }
  bool within = position_in_frame(at, from_axis_of(at)).margin >= 0.0;
  return exact(within && count > 0.0 ? sum / count : -1.0);
}

#endif
