// SPDX-License-Identifier: Apache-2.0
#include "renderer/parameters/view_frame.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "shaders/bindings.h"

namespace fanlight {

namespace {

std::array<double, 3> to_array(const glm::dvec3& vector) {
  return {vector.x, vector.y, vector.z};
}

SurfacePart surface_part(const Scene& scene, const Viewport& port) {
  const int shown = shown_by(scene.mode);
  if (shown == FANLIGHT_SHOW_COLOUR) return {};
  return {.left = port.left,
          .top = port.top,
          .width = port.width,
          .height = port.height,
          .as_depth = shown == FANLIGHT_SHOW_DEPTH,
          .seen_through = is_glass(scene)};
}

}  // namespace

glm::dvec3 to_vector(const Point& point) {
  return {point.x_mm, point.y_mm, point.z_mm};
}

bool is_perspective(const Scene::Camera& camera) {
  return camera.projection == Projection::kPerspective;
}

double eye_distance_mm(const Scene::Camera& camera) {
  return camera.field_mm / (2 * std::tan(radians(camera.opening_deg) / 2));
}

double eye_height_mm(const Scene::Camera& camera) {
  return eye_distance_mm(camera) - camera.distance_mm;
}

ViewFrame view_frame(const Scene::Camera& camera) {
  const double yaw = radians(camera.yaw_deg);
  const double pitch = radians(camera.pitch_deg);
  const double roll = radians(camera.roll_deg);
  const glm::dvec3 forward(-std::sin(yaw) * std::cos(pitch), std::cos(yaw) * std::cos(pitch),
                           -std::sin(pitch));
  const glm::dvec3 level(std::cos(yaw), std::sin(yaw), 0);
  const glm::dvec3 upright = glm::cross(level, forward);
  // A camera that turns clockwise dips its right side.
  return {.centre = to_vector(camera.target) - camera.distance_mm * forward,
          .right = std::cos(roll) * level - std::sin(roll) * upright,
          .up = std::cos(roll) * upright + std::sin(roll) * level,
          .forward = forward};
}

PlaneAxes plane_axes(const Scene::Slice& slice) {
  const ViewFrame turned =
      view_frame({.yaw_deg = slice.yaw_deg, .pitch_deg = slice.pitch_deg, .roll_deg = slice.roll_deg});
  return {.x = turned.right, .y = turned.forward, .z = turned.up};
}

Viewport viewport(const Scene& scene, PictureSize size) {
  Viewport port{.width = size.width, .height = size.height};
  if (scene.mode == Mode::kSlice || scene.mode == Mode::kTomography) port.width = 0;
  if (scene.mode == Mode::kTomography) port.height /= 3;
  if (scene.mode == Mode::kSurfaceAndVolume) port.width = size.width / 2;
  if (scene.mode == Mode::kSlices) {
    port.left = size.width / 2;
    port.top = size.height / 2;
    port.width -= port.left;
    port.height -= port.top;
  }
  // Beside the volume the surface has a narrow part: the field then spans its width.
  const std::uint32_t side =
      scene.mode == Mode::kSurfaceAndVolume ? std::min(port.width, port.height) : port.height;
  port.pixel_mm = scene.camera.field_mm / side;
  return port;
}

int shown_by(Mode mode) {
  switch (mode) {
    case Mode::kSurface:
    case Mode::kSurfaceAndVolume:
    case Mode::kSlices:
      return FANLIGHT_SHOW_SURFACE;
    case Mode::kDepth:
      return FANLIGHT_SHOW_DEPTH;
    default:
      return FANLIGHT_SHOW_COLOUR;
  }
}

PictureView picture_view(const Scene& scene, PictureSize size) {
  const ViewFrame view = view_frame(scene.camera);
  const Viewport port = viewport(scene, size);
  const double eye_mm = eye_distance_mm(scene.camera);
  const bool widens = is_perspective(scene.camera);
  return {.origin_mm = to_array(view.centre),
          .right = to_array(view.right),
          .down = to_array(-view.up),
          .forward = to_array(view.forward),
          .mm_per_pixel = port.pixel_mm * (widens ? eye_height_mm(scene.camera) / eye_mm : 1),
          .mm_per_pixel_per_mm = widens ? port.pixel_mm / eye_mm : 0,
          .middle_column = port.centre_column(),
          .middle_row = port.centre_row(),
          .part = surface_part(scene, port)};
}

}  // namespace fanlight
