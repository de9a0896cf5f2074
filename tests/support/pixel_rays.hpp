// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <glm/vec3.hpp>

#include "renderer/parameters/view_frame.hpp"

namespace fanlight::test {

/// The ray of a pixel in the transducer frame, mm. at(t) is the point at depth t below the view plane.
struct PixelRay {
  glm::dvec3 origin;
  glm::dvec3 direction;  ///< its component along the view has length 1, so in perspective it is longer

  glm::dvec3 at(double depth_mm) const { return origin + depth_mm * direction; }
};

/// The rays of a picture, computed from the scene alone: the reference must be independent of the renderer's
/// parameters.
class PixelRays {
 public:
  PixelRays(const Scene& scene, PictureSize size)
      : frame_(view_frame(scene.camera)), port_(viewport(scene, size)), depths_(scene.rays) {
    if (scene.camera.projection == Projection::kParallel) return;
    per_eye_mm_ = 1 / eye_distance_mm(scene.camera);
    eye_height_mm_ = eye_distance_mm(scene.camera) - scene.camera.distance_mm;
    at_plane_ = eye_height_mm_ * per_eye_mm_;
  }

  const Viewport& port() const { return port_; }

  PixelRay ray(std::uint32_t column, std::uint32_t row) const {
    const glm::dvec3 aside = right_mm(column) * frame_.right + up_mm(row) * frame_.up;
    return {frame_.centre + at_plane_ * aside, frame_.forward + per_eye_mm_ * aside};
  }

  /// Depths of the first and last sample; no sample lies before the eye.
  double first_mm() const {
    return per_eye_mm_ > 0 ? std::max(depths_.start_mm, -eye_height_mm_) : depths_.start_mm;
  }
  double last_mm() const { return depths_.end_mm; }

  /// The point of a pixel at a depth, in the view frame, mm: right, up, and height towards the viewer.
  glm::dvec3 place(std::uint32_t column, std::uint32_t row, double depth_mm) const {
    const double scale = at_plane_ + depth_mm * per_eye_mm_;
    return {scale * right_mm(column), scale * up_mm(row), -depth_mm};
  }

  /// Converts a direction from the view frame to the transducer frame.
  glm::dvec3 in_body(const glm::dvec3& in_view) const {
    return in_view.x * frame_.right + in_view.y * frame_.up - in_view.z * frame_.forward;
  }

 private:
  // Distance of the pixel from the centre of the picture, at the depth of the target.
  double right_mm(std::uint32_t column) const { return (column - port_.centre_column()) * port_.pixel_mm; }
  double up_mm(std::uint32_t row) const { return (port_.centre_row() - row) * port_.pixel_mm; }

  ViewFrame frame_;
  Viewport port_;
  Scene::Rays depths_;
  double per_eye_mm_ = 0;     // 1 / (distance from the eye to the target); 0: parallel rays
  double eye_height_mm_ = 0;  // of the eye above the view plane
  double at_plane_ = 1;       // distance between rays in the view plane / distance between rays at the target
};

}  // namespace fanlight::test
