// SPDX-License-Identifier: Apache-2.0
#include "acquisition/source/suggested_scene.hpp"

namespace fanlight {

Scene suggested_scene(const SourceDescription& source, std::uint32_t picture_height) {
  Scene scene = scene_for(source.geometry, source.first_angle_rad, source.last_angle_rad, picture_height);
  if (!source.subject) return scene;
  const double nearer = source.subject->height_mm / scene.camera.field_mm;
  // The view plane stays at the probe face.
  scene.camera.target = source.subject->middle;
  scene.camera.distance_mm = source.subject->middle.y_mm;
  scene.camera.field_mm = source.subject->height_mm;
  scene.slice.depth_mm = scene.camera.distance_mm;
  // The light keeps its depth: over a smaller part of the body it falls more steeply.
  scene.light.right_mm *= nearer;
  scene.light.up_mm *= nearer;
  place_fill_and_back_light(scene);
  limit(scene);
  return scene;
}

}  // namespace fanlight
