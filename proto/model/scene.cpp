// SPDX-License-Identifier: Apache-2.0
#include "proto/model/scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "proto/model/look.hpp"

namespace fanlight {

Result<void> check(const Scene& scene) {
  if (scene.rays.start_mm >= scene.rays.end_mm) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("rays.start_mm is {} and rays.end_mm is {}, expected the start before the end",
                             scene.rays.start_mm, scene.rays.end_mm)};
  }
  if (scene.rays.step_mm > 0 &&
      scene.rays.step_mm * kMostSamplesOnARay < scene.rays.end_mm - scene.rays.start_mm) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("rays.step_mm is {}, expected 0 or at most {} samples between start and end",
                             scene.rays.step_mm, kMostSamplesOnARay)};
  }
  const Scene::Crop& crop = scene.crop;
  if (crop.left_mm >= crop.right_mm || crop.near_mm >= crop.far_mm || crop.below_mm >= crop.above_mm) {
    return Error{
        ErrorCode::kInvalidArgument,
        fmt::format("the crop box is {} to {}, {} to {}, {} to {} mm, expected left below right, near "
                    "below far, below below above",
                    crop.left_mm, crop.right_mm, crop.near_mm, crop.far_mm, crop.below_mm, crop.above_mm)};
  }
  return {};
}

bool finds_surface(Mode mode) {
  return mode == Mode::kSurface || mode == Mode::kSurfaceAndVolume || mode == Mode::kDepth ||
         mode == Mode::kSlices;
}

double sample_step_mm(const Scene& scene, double finest_mm) {
  if (scene.rays.step_mm > 0) return scene.rays.step_mm;
  if (!finds_surface(scene.mode)) return finest_mm;
  return std::max(finest_mm, scene.detector.window_mm / kMostDetectorWindow);
}

void limit(Scene& scene) {
  for (const SceneField& field : scene_fields()) {
    if (field.is_text()) continue;
    const double value = field.get(scene);
    const double limited = std::clamp(value, field.minimum, field.maximum);
    if (limited == value) continue;
    Scene within = scene;
    field.set(within, limited);
    field.copy(scene, within);  // this field alone: a counted window does not take the place of one in mm
  }
}

bool is_glass(const Scene& scene) {
  return scene.glass.amount > 0 && (scene.mode == Mode::kSurface || scene.mode == Mode::kSlices);
}

FirstPass first_pass_changed(const Scene& from, const Scene& to) {
  const bool same_rays = from.size == to.size && is_glass(from) == is_glass(to);
  auto first = same_rays ? FirstPass::kNone : FirstPass::kCast;
  for (const SceneField& field : scene_fields()) {
    if (!field.same(from, to)) first = std::min(first, field.first_pass);
  }
  return first;
}

Scene relit(const Scene& cast, const Scene& newest) {
  Scene scene = cast;
  for (const SceneField& field : scene_fields()) {
    if (field.first_pass >= FirstPass::kFilter) field.copy(scene, newest);
  }
  // Without the edges behind a surface it cannot be shown as glass.
  if (is_glass(cast) != is_glass(scene)) scene.glass = cast.glass;
  return scene;
}

namespace {

// Windows of scene_for(): a few resolution cells of usual probes.
constexpr double kSpeckleMm = 2.2;
constexpr double kDetectorMm = 6;
constexpr double kFilterMm = 6;
// Depths of one surface may differ by this within such a window: it is slanted.
constexpr double kStepMm = 12;
constexpr double kReach = 0.6;

}  // namespace

void place_fill_and_back_light(Scene& scene) {
  const double field_mm = scene.camera.field_mm;
  const auto place = [&](Scene::Lamp& lamp, double right, double up, double depth) {
    const auto tenth = [](double value) { return std::round(10 * value) / 10; };
    lamp.right_mm = tenth(right * field_mm);
    lamp.up_mm = tenth(up * field_mm);
    lamp.depth_mm = tenth(scene.camera.distance_mm + depth * field_mm);
  };
  place(scene.fill_light, 0.6, -0.1, -0.5);
  place(scene.back_light, 0.3, 0.8, 0.4);
}

Scene scene_for(const FanGeometry& geometry, double first_angle_rad, double last_angle_rad,
                std::uint32_t picture_height) {
  const double depth_mm = geometry.depth_mm();
  const double middle_rad = (first_angle_rad + last_angle_rad) / 2;
  const double swept_rad = std::abs(last_angle_rad - first_angle_rad);
  const double width_mm = geometry.right_mm() - geometry.left_mm();
  const double height_mm =
      2 * (geometry.motor_radius_mm + depth_mm / 2) * std::sin(std::min(swept_rad, kPi) / 2);

  Scene scene;
  scene.camera.target = geometry.point((geometry.left_mm() + geometry.right_mm()) / 2,
                                       {.angle_rad = middle_rad, .depth_mm = depth_mm / 2});
  scene.camera.pitch_deg = degrees(-middle_rad);
  scene.camera.distance_mm = depth_mm / 2;
  scene.camera.field_mm = std::max(width_mm, height_mm);
  scene.rays.end_mm = depth_mm;
  scene.slice.depth_mm = scene.camera.distance_mm;
  scene.light.right_mm = -0.42 * scene.camera.field_mm;
  scene.light.up_mm = 0.42 * scene.camera.field_mm;
  scene.light.depth_mm = -0.4 * scene.camera.field_mm;
  place_fill_and_back_light(scene);
  // The defaults apply to 512 pixels. In a picture of another height, the scaled odd window covers the same
  // length in the body.
  const auto scaled = [&](int window) {
    const int radius = window / 2;
    return 2 * static_cast<int>(std::lround(radius * (picture_height / 512.0))) + 1;
  };
  scene.filter.size = scaled(scene.filter.size);
  scene.filter.kind = DepthFilter::kEdgePreserving;
  scene.filter.size_mm = kFilterMm;
  scene.filter.step_mm = kStepMm;
  scene.speckle.size_mm = kSpeckleMm;
  scene.speckle.noise = 0;
  scene.detector.window_mm = kDetectorMm;
  scene.detector.threshold = 0;
  scene.detector.place = SurfacePlace::kLevel;
  scene.detector.reach = kReach;
  scene.detector.frame_steps = FrameSteps::kRemoved;
  scene.filter.islands = scaled(scene.filter.islands);
  scene.filter.holes = scaled(scene.filter.holes);
  static_cast<void>(apply_look(scene, looks().front().name));
  // A fan may be larger than the ranges of the fields.
  limit(scene);
  return scene;
}

}  // namespace fanlight
