#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "proto/fan_geometry.hpp"
#include "proto/scene.hpp"
#include "renderer/fan_table.hpp"
#include "shaders/cast_parameters.h"
#include "shaders/light_parameters.h"

namespace fanlight {

/// Size of a picture in pixels.
struct PictureSize {
  std::uint32_t width = 512;
  std::uint32_t height = 512;
};

/// The view frame of a camera in the transducer frame (mm): the centre of the picture in the view plane, and
/// three unit vectors. right x forward = up.
struct ViewFrame {
  glm::dvec3 centre;
  glm::dvec3 right;
  glm::dvec3 up;
  glm::dvec3 forward;
};

ViewFrame view_frame(const Scene::Camera& camera);

/// Side of a picture's pixel in the body: the field is the picture's height.
double pixel_mm(const Scene::Camera& camera, PictureSize size);

/// What a volume adds to the geometry of its source.
struct VolumeExtent {
  double first_angle_rad = 0;  ///< smallest and largest angle of its frames
  double last_angle_rad = 0;
  std::uint32_t frames = 0;
  std::uint32_t frame_capacity = 0;  ///< slices of the texture that holds it
};

/// What pass 1 needs to cast this scene through a volume. Samples lie at rays.start_mm + k * step below the
/// view plane; only those k are taken that can meet the fan's box, none where no ray can.
shaders::CastParameters cast_parameters(const Scene& scene, PictureSize size, const FanGeometry& geometry,
                                        const FanTable& table, const VolumeExtent& volume);

/// What passes 2 and 3 need.
shaders::LightParameters light_parameters(const Scene& scene, PictureSize size);

}  // namespace fanlight
