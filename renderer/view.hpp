#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>

#include "proto/fan_geometry.hpp"
#include "proto/picture.hpp"
#include "proto/scene.hpp"
#include "renderer/angle_table.hpp"
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

/// The part of a picture that shows rays; elsewhere Mode::kSlices has its planes and Mode::kSurfaceAndVolume
/// the volume. Depths exist here alone.
struct Viewport {
  std::uint32_t left = 0;  ///< pixels
  std::uint32_t top = 0;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  double pixel_mm = 0;  ///< side of a pixel in the body, at the target's depth; the field is the height,
                        ///< or the smaller side beside the volume

  double centre_column() const { return left + 0.5 * (width - 1.0); }
  double centre_row() const { return top + 0.5 * (height - 1.0); }
};

Viewport viewport(const Scene& scene, PictureSize size);

/// Where the pixels of the viewport lie.
PictureView picture_view(const Scene& scene, PictureSize size);

/// In perspective, from the eye to the target: field / (2 tan(opening / 2)).
double eye_distance_mm(const Scene::Camera& camera);

/// What a volume adds to the geometry of its source.
struct VolumeExtent {
  double first_angle_rad = 0;  ///< smallest and largest angle of its frames
  double last_angle_rad = 0;
  std::uint32_t frames = 0;
  std::uint32_t frame_capacity = 0;  ///< slices of the texture that holds it
};

/// What pass 1 needs to cast this scene through a volume. Samples lie at depths rays.start_mm + k * step /
/// (length of the ray a mm of depth) for whole k.
shaders::CastParameters cast_parameters(const Scene& scene, PictureSize size, const FanGeometry& geometry,
                                        const AngleTable& table, const VolumeExtent& volume);

/// The transfer function by grey level: colour, and the opacity of one sample of `step_mm`.
using TransferTable = std::array<glm::vec4, 256>;
TransferTable transfer_table(const TransferFunction& transfer, double step_mm);

/// What passes 2 and 3 need. `farthest_mm` is a depth that no surface exceeds.
shaders::LightParameters light_parameters(const Scene& scene, PictureSize size, double farthest_mm);

/// The colours, as displayed, that a map gives to a brightness of 0, 1/3, 2/3 and 1; linear in between.
std::array<glm::dvec3, FANLIGHT_MAP_POINTS> colour_map_points(ColourMap map);

/// What pass 1 keeps along each ray in a mode: FANLIGHT_KEEP_...
int kept_by(Mode mode);

}  // namespace fanlight
