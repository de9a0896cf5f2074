// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "proto/model/picture.hpp"
#include "proto/model/picture_size.hpp"
#include "proto/model/scene.hpp"

namespace fanlight {

/// The view frame of a camera in the transducer frame (mm): the centre of the picture in the view plane, and
/// three unit vectors. right x forward = up.
struct ViewFrame {
  glm::dvec3 centre;
  glm::dvec3 right;
  glm::dvec3 up;
  glm::dvec3 forward;
};

ViewFrame view_frame(const Scene::Camera& camera);

/// The part of a picture that rays are cast for. Only this part has depths. Mode::kSlices shows its planes
/// next to it, Mode::kSurfaceAndVolume the volume.
struct Viewport {
  std::uint32_t left = 0;  ///< pixels
  std::uint32_t top = 0;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  double pixel_mm = 0;  ///< side of a pixel in the body, at the target's depth. camera.field_mm spans the
                        ///< height, or the smaller side next to the volume

  double centre_column() const { return left + 0.5 * (width - 1.0); }
  double centre_row() const { return top + 0.5 * (height - 1.0); }
};

Viewport viewport(const Scene& scene, PictureSize size);

/// The size of the scene's picture.
inline PictureSize size_of(const Scene& scene, PictureSize usual) {
  return scene.size.value_or(usual);
}

/// Axes of the planes A (right x, down y), B (right z, down y) and C (right x, down -z) of Scene::Slice.
struct PlaneAxes {
  glm::dvec3 x, y, z;
};
PlaneAxes plane_axes(const Scene::Slice& slice);

/// What a picture of this mode shows inside the viewport: FANLIGHT_SHOW_SURFACE, _DEPTH or _COLOUR. The first
/// two come from the depth map.
int shown_by(Mode mode);

/// Position of the viewport's pixels in the transducer frame, and whether they show a surface.
PictureView picture_view(const Scene& scene, PictureSize size);

bool is_perspective(const Scene::Camera& camera);

/// In perspective, from the eye to the target: field / (2 tan(opening / 2)).
double eye_distance_mm(const Scene::Camera& camera);

/// In perspective, height of the eye above the view plane; negative where the eye lies beyond the plane.
double eye_height_mm(const Scene::Camera& camera);

/// A point of the transducer frame (mm) as a vector.
glm::dvec3 to_vector(const Point& point);

}  // namespace fanlight
