// SPDX-License-Identifier: Apache-2.0
// CPU twin of a ray and of what crop box and clip planes leave of it.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "proto/model/fan_geometry.hpp"
#include "proto/model/scene.hpp"
#include "renderer/parameters/view_frame.hpp"

namespace fanlight::test {

inline double step_of(const Scene& scene, const FanGeometry& geometry) {
  return scene.rays.step_mm > 0 ? scene.rays.step_mm : geometry.finest_mm();
}

/// An interval of depths below the view plane.
struct DepthInterval {
  double first_mm = -HUGE_VAL;
  double last_mm = HUGE_VAL;
  bool holds(double depth_mm) const { return depth_mm >= first_mm && depth_mm <= last_mm; }
};

/// The point at depth t below the view plane is origin + t direction. Transducer frame, mm.
struct Ray {
  glm::dvec3 origin;
  glm::dvec3 direction;
  double eye_mm = -HUGE_VAL;  // depth of the eye; no sample lies before it

  glm::dvec3 at(double depth_mm) const { return origin + depth_mm * direction; }
};

/// The ray of a pixel. `right_mm`, `up_mm`: its distance from the centre of the picture, at the depth of the
/// target.
inline Ray ray_through(const Scene::Camera& camera, double right_mm, double up_mm) {
  const ViewFrame view = view_frame(camera);
  if (camera.projection == Projection::kParallel) {
    return {.origin = view.centre + right_mm * view.right + up_mm * view.up, .direction = view.forward};
  }
  const double to_target_mm = eye_distance_mm(camera);
  const double to_plane_mm = to_target_mm - camera.distance_mm;
  const glm::dvec3 eye = view.centre - to_plane_mm * view.forward;
  const glm::dvec3 direction =
      view.forward + (right_mm / to_target_mm) * view.right + (up_mm / to_target_mm) * view.up;
  return {.origin = eye + to_plane_mm * direction, .direction = direction, .eye_mm = -to_plane_mm};
}

/// Clips the interval of the ray to the half space normal . p >= distance.
inline void clip_to_half_space(DepthInterval& interval, const Ray& ray, const glm::dvec3& normal,
                               double distance) {
  const double slope = glm::dot(normal, ray.direction);
  const double margin = glm::dot(normal, ray.origin) - distance;
  if (slope > 0) interval.first_mm = std::max(interval.first_mm, -margin / slope);
  if (slope < 0) interval.last_mm = std::min(interval.last_mm, -margin / slope);
  if (slope == 0 && margin < 0) interval = {.first_mm = HUGE_VAL, .last_mm = -HUGE_VAL};
}

/// The part of the ray in the crop box and on the visible side of both clip planes: `cropped` in
/// fan_volume.h.
inline DepthInterval cropped(const Scene& scene, const Ray& ray) {
  const Scene::Crop& crop = scene.crop;
  DepthInterval shown;
  clip_to_half_space(shown, ray, {1, 0, 0}, crop.left_mm);
  clip_to_half_space(shown, ray, {-1, 0, 0}, -crop.right_mm);
  clip_to_half_space(shown, ray, {0, 1, 0}, crop.near_mm);
  clip_to_half_space(shown, ray, {0, -1, 0}, -crop.far_mm);
  clip_to_half_space(shown, ray, {0, 0, 1}, crop.below_mm);
  clip_to_half_space(shown, ray, {0, 0, -1}, -crop.above_mm);
  for (const Scene::Clip& clip : {scene.clip1, scene.clip2}) {
    const glm::dvec3 normal(clip.normal_x, clip.normal_y, clip.normal_z);
    clip_to_half_space(shown, ray, normal, clip.distance_mm * glm::length(normal));
  }
  return shown;
}

}  // namespace fanlight::test
