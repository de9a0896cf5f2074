// SPDX-License-Identifier: Apache-2.0
#include "acquisition/phantom/body_scene.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "acquisition/phantom/fetal_shapes.hpp"
#include "proto/model/fan_geometry.hpp"

namespace fanlight {

namespace {

using glm::vec3;

constexpr float kHeadDepthMm = 106;  // of the point between the ears
// The wall of the uterus: the inside of a sphere.
constexpr vec3 kWallMiddleMm{0, 30, 0};
constexpr float kWallRadiusMm = 122;

constexpr float kMostAcrossMm = 10;

constexpr float kSphereRadiusMm = 30;
constexpr float kMiddleDepthMm = 90;
constexpr double kPlaneTiltDeg = 20;

float sphere_mm(const vec3& at) {
  return glm::length(at) - kSphereRadiusMm;
}

/// Tissue where y is positive.
float plane_mm(const vec3& at) {
  return -at.y;
}

/// Made when first needed, and kept.
const std::shared_ptr<const DistanceGrid>& head() {
  static const auto made =
      std::make_shared<const DistanceGrid>(fetal_head_mm, vec3(-84, -72, -112), vec3(84, 58, 64), 0.9F);
  return made;
}
const std::shared_ptr<const DistanceGrid>& hand() {
  static const auto made =
      std::make_shared<const DistanceGrid>(fetal_hand_mm, vec3(-22, -34, -78), vec3(32, 18, 46), 0.8F);
  return made;
}
const std::shared_ptr<const DistanceGrid>& cord() {
  static const auto made =
      std::make_shared<const DistanceGrid>(umbilical_cord_mm, vec3(-64, -20, -80), vec3(32, 36, -34), 0.9F);
  return made;
}

/// Slow oscillation between -amplitude and +amplitude.
double sway(double amplitude, double period_s, double phase, double time_s) {
  return amplitude * std::sin(2 * kPi * (time_s / period_s + phase));
}

struct Turn {
  double yaw_rad = 0;  // about the own z axis
  double pitch_rad = 0;
  double roll_rad = 0;
};

/// Faces the probe: the own y axis points to it. `to_probe`: position as (x, -y, z).
BodyScene::Pose facing_probe(const Turn& turn, const vec3& to_probe) {
  const auto cosine = [](double angle_rad) { return static_cast<float>(std::cos(angle_rad)); };
  const auto sine = [](double angle_rad) { return static_cast<float>(std::sin(angle_rad)); };
  const float cy = cosine(turn.yaw_rad);
  const float sy = sine(turn.yaw_rad);
  const float cp = cosine(turn.pitch_rad);
  const float sp = sine(turn.pitch_rad);
  const float cr = cosine(turn.roll_rad);
  const float sr = sine(turn.roll_rad);
  // Given by rows; glm stores columns.
  const glm::mat3 yaw = glm::transpose(glm::mat3(cy, sy, 0, -sy, cy, 0, 0, 0, 1));
  const glm::mat3 pitch = glm::transpose(glm::mat3(1, 0, 0, 0, cp, -sp, 0, sp, cp));
  const glm::mat3 roll = glm::transpose(glm::mat3(cr, 0, -sr, 0, 1, 0, sr, 0, cr));
  const glm::mat3 towards_probe(1, 0, 0, 0, -1, 0, 0, 0, 1);
  return {.turn = roll * pitch * yaw * towards_probe, .origin_mm = {to_probe.x, -to_probe.y, to_probe.z}};
}

}  // namespace

BodyScene::BodyScene(Kind kind, bool moving) : kind_(kind), moving_(moving) {
  switch (kind) {
    case Kind::kFace:
      bodies_ = {{head(), true}, {hand(), true}, {cord(), false}};
      break;
    case Kind::kSphere:
      bodies_ = {{std::make_shared<const DistanceGrid>(sphere_mm, vec3(-36), vec3(36), 0.5F), false}};
      break;
    case Kind::kPlane:
      bodies_ = {
          {std::make_shared<const DistanceGrid>(plane_mm, vec3(-150, -6, -150), vec3(150, 6, 150), 1.5F),
           false}};
      break;
  }
}

BodyScene::Poses BodyScene::poses_at(double time_s) const {
  Poses poses;
  if (kind_ != Kind::kFace) {
    const auto tilt_rad = static_cast<float>(kind_ == Kind::kPlane ? radians(kPlaneTiltDeg) : 0);
    const float cosine = std::cos(tilt_rad);
    const float sine = std::sin(tilt_rad);
    poses[0] = {.turn = glm::mat3(1, 0, 0, 0, cosine, sine, 0, -sine, cosine),
                .origin_mm = {0, kMiddleDepthMm, 0}};
    return poses;
  }
  const auto moved = [&](double amplitude, double period_s, double phase) {
    return moving_ ? sway(amplitude, period_s, phase, time_s) : 0.0;
  };
  const vec3 breath(moved(1.5, 6.7, 0), moved(1.2, 3.1, 0.2), moved(1.0, 5.9, 0.4));
  const vec3 head_mm = vec3(0, -kHeadDepthMm, 2) + breath;
  poses[0] = facing_probe({.yaw_rad = 0.5 + moved(0.06, 7.3, 0.05),
                           .pitch_rad = 0.12 + moved(0.03, 5.3, 0.3),
                           .roll_rad = 0.1 + moved(0.03, 9.1, 0.1)},
                          head_mm);
  const vec3 cheek_offset(28 + moved(2.5, 4.7, 0.6), 30 + moved(1.5, 3.9, 0), -52 + moved(4, 4.3, 0.1));
  poses[1] = facing_probe({.yaw_rad = 0.75 + moved(0.12, 4.1, 0.7),
                           .pitch_rad = -0.1 + moved(0.1, 3.7, 0.2),
                           .roll_rad = -0.25 + moved(0.12, 4.9, 0.5)},
                          vec3(0, -kHeadDepthMm, 2) + cheek_offset);
  poses[2] = facing_probe({}, vec3(moved(0.8, 6.1, 0.3), -kHeadDepthMm, 2));
  return poses;
}

BodyScene::Lines BodyScene::in_bodies(const Poses& poses, const Line& line) const {
  Lines lines;
  for (std::size_t body = 0; body < bodies_.size(); ++body) {
    const Pose& pose = poses[body];
    lines[body] = {.from_mm = pose.turn * (line.from_mm - pose.origin_mm),
                   .along = pose.turn * line.along,
                   .across = pose.turn * line.across};
    const DistanceGrid& surface = *bodies_[body].surface;
    const vec3 to_middle = surface.middle_mm() - lines[body].from_mm;
    const float beside_mm = glm::length(glm::cross(to_middle, lines[body].along));
    lines[body].passes = beside_mm < surface.radius_mm() + kNearMm;
  }
  lines[kMostBodies] = {.from_mm = line.from_mm - kWallMiddleMm, .along = line.along, .across = line.across};
  return lines;
}

BodyScene::Found BodyScene::at(const Lines& lines, float along_mm, float across_mm) const {
  const auto point = [&](const Line& line) {
    return line.from_mm + along_mm * line.along + across_mm * line.across;
  };
  Found found{.distance_mm = kWallRadiusMm - glm::length(point(lines[kMostBodies]))};
  for (std::size_t body = 0; body < bodies_.size(); ++body) {
    if (!lines[body].passes) {
      found.distance_mm = std::min(found.distance_mm, kNearMm - kMostAcrossMm);
      continue;
    }
    const float distance_mm = bodies_[body].surface->at(point(lines[body]));
    if (distance_mm < found.distance_mm) found = {distance_mm, bodies_[body].has_bone};
  }
  return found;
}

float BodyScene::distance_mm(const Poses& poses, const vec3& at_mm) const {
  return at(in_bodies(poses, {.from_mm = at_mm}), 0, 0).distance_mm;
}

}  // namespace fanlight
