// SPDX-License-Identifier: Apache-2.0
#include "tests/accuracy/known_views.hpp"

#include "tests/accuracy/test_fans.hpp"

namespace fanlight::test {

namespace {

Scene oblique(Scene scene) {
  scene.camera.yaw_deg = 20;
  scene.camera.pitch_deg = -15;
  scene.camera.roll_deg = 30;
  return scene;
}

}  // namespace

Scene scene_from_probe(const ScannedFan& fan, Projection projection) {
  constexpr double kFieldMm = 40;
  constexpr double kDistanceMm =
      45;  // keeps the view plane before the fan in every orientation of the camera
  Scene scene = scene_for(fan.geometry, fan.first_angle_rad, fan.last_angle_rad);
  scene.camera.target = {.x_mm = 0, .y_mm = kSurfaceDepthMm, .z_mm = 0};
  scene.camera.pitch_deg = 0;
  scene.camera.field_mm = kFieldMm;
  scene.camera.distance_mm = kDistanceMm;
  scene.camera.projection = projection;
  scene.rays.end_mm = 2 * kDistanceMm;
  return scene;
}

KnownView known_view(const Scene& scene, const ScannedFan& fan, const KnownSurface& surface) {
  const PixelRays rays(scene, kViewSize);
  return {scene, kViewSize, rays, depth_truth(rays, kViewSize, fan, surface)};
}

KnownView view_from_probe(const ScannedFan& fan, const KnownSurface& surface, Projection projection) {
  return known_view(scene_from_probe(fan, projection), fan, surface);
}

std::vector<KnownView> known_views(const ScannedFan& fan, const KnownSurface& surface,
                                   Projection projection) {
  return {view_from_probe(fan, surface, projection),
          known_view(oblique(scene_from_probe(fan, projection)), fan, surface)};
}

}  // namespace fanlight::test
