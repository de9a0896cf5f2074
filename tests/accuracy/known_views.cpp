// SPDX-License-Identifier: Apache-2.0
#include "tests/accuracy/known_views.hpp"

#include "tests/accuracy/test_fans.hpp"

namespace fanlight::test {

namespace {

Scene close_scene(const ScannedFan& fan, Projection projection) {
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

Scene oblique(Scene scene) {
  scene.camera.yaw_deg = 20;
  scene.camera.pitch_deg = -15;
  scene.camera.roll_deg = 30;
  return scene;
}

}  // namespace

std::vector<KnownView> known_views(const ScannedFan& fan, const KnownSurface& surface,
                                   Projection projection) {
  const Scene from_probe = close_scene(fan, projection);
  std::vector<KnownView> views;
  for (const Scene& scene : {from_probe, oblique(from_probe)}) {
    const PixelRays rays(scene, kViewSize);
    views.push_back({scene, kViewSize, rays, depth_truth(rays, kViewSize, fan, surface)});
  }
  return views;
}

}  // namespace fanlight::test
