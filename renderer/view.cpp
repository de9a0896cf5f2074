#include "renderer/view.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace fanlight {

namespace {

constexpr double kGreyLevels = 255;

glm::dvec3 vector(const Point& point) {
  return {point.x_mm, point.y_mm, point.z_mm};
}

struct DepthRange {
  double nearest_mm;
  double farthest_mm;
};

/// Depths below the view plane between which the fan's box lies.
DepthRange depths_of(const FanTable::Box& box, const ViewFrame& view) {
  DepthRange range{HUGE_VAL, -HUGE_VAL};
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 at((corner & 1) != 0 ? box.highest.x_mm : box.lowest.x_mm,
                        (corner & 2) != 0 ? box.highest.y_mm : box.lowest.y_mm,
                        (corner & 4) != 0 ? box.highest.z_mm : box.lowest.z_mm);
    const double depth_mm = glm::dot(at - view.centre, view.forward);
    range.nearest_mm = std::min(range.nearest_mm, depth_mm);
    range.farthest_mm = std::max(range.farthest_mm, depth_mm);
  }
  return range;
}

/// The samples of every ray: start + k * step for whole k, as far as they can lie in the fan's box. Cutting
/// keeps k whole, so that it never moves a sample.
void set_samples(shaders::CastParameters& to, const Scene::Rays& rays, double finest_mm, DepthRange box) {
  const double end_mm = std::min(rays.end_mm, box.farthest_mm);
  const double step_mm = rays.step_mm > 0
                             ? rays.step_mm
                             : std::max(finest_mm, (end_mm - rays.start_mm) / (kMostSamplesOnARay - 1));
  const double before = std::max(0.0, std::floor((box.nearest_mm - rays.start_mm) / step_mm));
  const double start_mm = rays.start_mm + before * step_mm;
  to.start = static_cast<float>(start_mm);
  to.step = static_cast<float>(step_mm);
  to.steps = end_mm < start_mm ? 0U : static_cast<std::uint32_t>((end_mm - start_mm) / step_mm) + 1;
}

void set_frames(shaders::CastParameters& to, const FanGeometry& geometry, const VolumeExtent& volume) {
  to.column_scale = static_cast<float>(1 / geometry.pixel_width_mm);
  to.column_offset = static_cast<float>(geometry.face_column);
  to.row_scale = static_cast<float>(1 / geometry.pixel_height_mm);
  to.row_offset = static_cast<float>(geometry.face_row);
  to.last_row = static_cast<float>(geometry.rows - 1);
  to.last_frame = static_cast<float>(volume.frames - 1);
  to.voxel_scale = 1.0F / glm::vec3(geometry.columns, geometry.rows, volume.frame_capacity);
  to.left = static_cast<float>(geometry.left_mm());
  to.right = static_cast<float>(geometry.right_mm());
  to.first_angle = {std::cos(volume.first_angle_rad), std::sin(volume.first_angle_rad)};
  to.last_angle = {std::cos(volume.last_angle_rad), std::sin(volume.last_angle_rad)};
  to.motor_radius = static_cast<float>(geometry.motor_radius_mm);
  to.farthest = static_cast<float>(geometry.motor_radius_mm + geometry.depth_mm());
}

void set_sector(shaders::CastParameters& to, const FanGeometry& geometry) {
  const FanGeometry::Sector& sector = geometry.sector;
  const double margin_mm = std::max(geometry.pixel_width_mm, geometry.pixel_height_mm);
  const auto squared = [](double value) { return static_cast<float>(value * value); };
  // Without a sector every comparison holds: an apex so far back that its cone is wider than any frame.
  constexpr double kFarMm = 1e4;
  const bool known = sector.half_angle_deg > 0;
  to.sector_radius = static_cast<float>(known ? sector.probe_radius_mm : kFarMm);
  to.sector_tangent = static_cast<float>(known ? std::tan(radians(sector.half_angle_deg)) : kFarMm);
  to.sector_margin = static_cast<float>(known ? margin_mm : 0);
  to.sector_near_squared = known ? squared(sector.probe_radius_mm + margin_mm) : 0;
  to.sector_far_squared = squared(known && sector.reach_mm > 0 ? sector.reach_mm - margin_mm : 10 * kFarMm);
}

}  // namespace

ViewFrame view_frame(const Scene::Camera& camera) {
  const double yaw = radians(camera.yaw_deg);
  const double pitch = radians(camera.pitch_deg);
  const double roll = radians(camera.roll_deg);
  const glm::dvec3 forward(-std::sin(yaw) * std::cos(pitch), std::cos(yaw) * std::cos(pitch),
                           -std::sin(pitch));
  const glm::dvec3 level(std::cos(yaw), std::sin(yaw), 0);
  const glm::dvec3 upright = glm::cross(level, forward);
  // A camera that turns clockwise dips its right side.
  return {.centre = vector(camera.target) - camera.distance_mm * forward,
          .right = std::cos(roll) * level - std::sin(roll) * upright,
          .up = std::cos(roll) * upright + std::sin(roll) * level,
          .forward = forward};
}

double pixel_mm(const Scene::Camera& camera, PictureSize size) {
  return camera.field_mm / size.height;
}

shaders::CastParameters cast_parameters(const Scene& scene, PictureSize size, const FanGeometry& geometry,
                                        const FanTable& table, const VolumeExtent& volume) {
  const ViewFrame view = view_frame(scene.camera);
  const double pixel = pixel_mm(scene.camera, size);
  const double left_pixels = 0.5 * (size.width - 1.0);
  const double up_pixels = 0.5 * (size.height - 1.0);

  shaders::CastParameters to{};
  to.origin = view.centre + pixel * (up_pixels * view.up - left_pixels * view.right);
  to.right_step = pixel * view.right;
  to.down_step = -pixel * view.up;
  to.forward = view.forward;
  to.width = size.width;
  to.height = size.height;
  set_samples(to, scene.rays, std::min(geometry.pixel_width_mm, geometry.pixel_height_mm),
              depths_of(table.box(), view));

  to.table_scale = {table.z_axis().scale, table.y_axis().scale};
  to.table_offset = {table.z_axis().offset, table.y_axis().offset};
  set_frames(to, geometry, volume);
  set_sector(to, geometry);

  to.threshold = static_cast<float>(scene.detector.threshold / kGreyLevels);
  to.edge_sign = scene.detector.sign == EdgeSign::kDarkToBright   ? 1
                 : scene.detector.sign == EdgeSign::kBrightToDark ? -1
                                                                  : 0;
  to.transparent = static_cast<float>(scene.transfer.transparent / kGreyLevels);
  to.ramp_scale = static_cast<float>(kGreyLevels / (scene.transfer.opaque - scene.transfer.transparent));
  to.step_opacity = static_cast<float>(1 - std::pow(1 - scene.transfer.opacity_per_mm, to.step));
  return to;
}

shaders::LightParameters light_parameters(const Scene& scene, PictureSize size) {
  const Scene::Light& light = scene.light;
  shaders::LightParameters to{};
  to.width = size.width;
  to.height = size.height;
  to.pixel = static_cast<float>(pixel_mm(scene.camera, size));
  to.filter_radius = scene.filter.size / 2;
  to.light = {light.right_mm, light.up_mm, light.depth_mm};
  to.ambient = static_cast<float>(light.ambient);
  to.diffuse = static_cast<float>(light.diffuse);
  to.specular = static_cast<float>(light.specular);
  to.shininess = static_cast<float>(light.shininess);
  to.shadow = static_cast<float>(scene.shadow.coefficient);
  to.shadow_top = static_cast<float>(scene.rays.start_mm);
  to.skin = {0.90F, 0.58F, 0.42F};
  to.show_volume = scene.mode == Mode::kVolume ? 1 : 0;
  to.mean = scene.finish == Finish::kMean ? 1 : 0;
  return to;
}

}  // namespace fanlight
