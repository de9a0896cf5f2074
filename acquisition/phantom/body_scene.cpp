// SPDX-License-Identifier: Apache-2.0
#include "acquisition/phantom/body_scene.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <random>

#include "acquisition/phantom/fetal_shapes.hpp"
#include "acquisition/phantom/sway.hpp"
#include "proto/model/fan_geometry.hpp"

namespace fanlight {

namespace {

using glm::vec3;

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

BodyScene::BodyScene(Kind kind, bool moving, std::uint64_t seed, bool has_near_wall)
    : kind_(kind), moving_(moving) {
  switch (kind) {
    case Kind::kFace:
    case Kind::kWomb:
      bodies_ = {{head(), Part::kHead, true}, {hand(), Part::kHand, true}, {cord(), Part::kCord, false}};
      if (kind == Kind::kWomb) lay_in_womb(seed);
      if (!has_near_wall) near_wall_.reset();
      break;
    case Kind::kSphere:
      bodies_ = {{std::make_shared<const DistanceGrid>(sphere_mm, vec3(-36), vec3(36), 0.5F)}};
      break;
    case Kind::kPlane:
      bodies_ = {
          {std::make_shared<const DistanceGrid>(plane_mm, vec3(-150, -6, -150), vec3(150, 6, 150), 1.5F)}};
      break;
    case Kind::kCyst:
      far_wall_ = {.middle_mm = {0, 75, 0}, .radius_mm = 20};
      break;
  }
}

BodyScene::NearWall::Depth BodyScene::NearWall::depth(const vec3& at_mm) const {
  constexpr float kFaceRadiusMm = 45;
  float wall_mm = thickness_mm;
  for (const Wave& wave : waves) {
    wall_mm += wave.amplitude_mm *
               std::sin(wave.across_per_mm * at_mm.x + wave.up_per_mm * at_mm.z + wave.phase_rad);
  }
  const float beside_x = (at_mm.x - placenta_mm.x) / placenta_radius_mm;
  const float beside_z = (at_mm.z - placenta_mm.y) / placenta_radius_mm;
  const float beside = beside_x * beside_x + beside_z * beside_z;
  wall_mm += placenta_mm.z * std::exp(-beside * beside);
  return {.below_mm = glm::length(at_mm + vec3(0, kFaceRadiusMm, 0)) - kFaceRadiusMm, .end_mm = wall_mm};
}

float BodyScene::NearWall::echo(const Depth& depth) {
  // Where a layer ends, as a share of the wall, and its power. Fat is 12 dB below muscle; a fascia is thin.
  struct Layer {
    float end;
    float power;
  };
  constexpr std::array<Layer, 6> kLayers = {
      {{0.10F, 2.0F}, {0.36F, 0.03F}, {0.40F, 3.0F}, {0.58F, 0.5F}, {0.62F, 3.0F}, {1.0F, 0.8F}}};
  const float share = depth.below_mm / depth.end_mm;
  for (const Layer& layer : kLayers)
    if (share < layer.end) return layer.power;
  return 1;
}

void BodyScene::lay_in_womb(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto between = [&](double low, double high) {
    // Not std::uniform_real_distribution, which differs between libraries.
    return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
  };
  const auto some = [&](double low, double high) { return static_cast<float>(between(low, high)); };
  NearWall wall{.thickness_mm = some(9, 20)};
  for (NearWall::Wave& wave : wall.waves) {
    wave = {.across_per_mm = some(-0.12, 0.12),
            .up_per_mm = some(-0.12, 0.12),
            .phase_rad = some(0, 2 * kPi),
            .amplitude_mm = some(0.3, 1.2)};
  }
  wall.placenta_mm = {some(-40, 40), some(-40, 40), some(0, 9)};
  wall.placenta_radius_mm = some(25, 45);
  near_wall_ = wall;
  rest_ = {.yaw_rad = between(-0.6, 0.6),
           .pitch_rad = between(-0.15, 0.3),
           .roll_rad = between(-0.35, 0.35),
           .head_mm = {some(-8, 8), 120, some(-6, 10)}};
  const float wanted_mm = some(2, 20);
  // Along y the gap changes as the head does.
  rest_.head_mm.y += wanted_mm - least_gap_mm();
  gap_mm_ = least_gap_mm();
}

float BodyScene::least_gap_mm() const {
  constexpr float kReachMm = 60;
  constexpr float kStepMm = 2;
  constexpr float kDeepestMm = 150;
  const Poses poses = poses_at(0);
  float least_mm = kDeepestMm;
  for (float x = -kReachMm; x <= kReachMm; x += kStepMm) {
    for (float z = -kReachMm; z <= kReachMm; z += kStepMm) {
      float inside_mm = -1;  // of the wall
      for (float y = 0; y < kDeepestMm; y += 0.5F) {
        const vec3 at(x, y, z);
        const Found found = this->found(poses, at);
        if (found.part == Part::kNearWall && found.distance_mm < 0) continue;
        if (inside_mm < 0) inside_mm = y;
        const bool is_body = found.part != Part::kFarWall && found.part != Part::kNearWall;
        if (is_body && found.distance_mm <= 0) {
          least_mm = std::min(least_mm, y - inside_mm);
          break;
        }
        // No body is nearer than that.
        y += std::max(0.0F, 0.6F * found.distance_mm - 0.5F);
      }
    }
  }
  return least_mm;
}

BodyScene::Poses BodyScene::poses_at(double time_s) const {
  Poses poses;
  if (kind_ != Kind::kFace && kind_ != Kind::kWomb) {
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
  const vec3 rest_mm(rest_.head_mm.x, -rest_.head_mm.y, rest_.head_mm.z);
  poses[0] = facing_probe({.yaw_rad = rest_.yaw_rad + moved(0.06, 7.3, 0.05),
                           .pitch_rad = rest_.pitch_rad + moved(0.03, 5.3, 0.3),
                           .roll_rad = rest_.roll_rad + moved(0.03, 9.1, 0.1)},
                          rest_mm + breath);
  const vec3 cheek_offset(34 + moved(2.5, 4.7, 0.6), 30 + moved(1.5, 3.9, 0), -52 + moved(4, 4.3, 0.1));
  poses[1] = facing_probe({.yaw_rad = 0.15 + moved(0.12, 4.1, 0.7),
                           .pitch_rad = -0.1 + moved(0.1, 3.7, 0.2),
                           .roll_rad = -0.25 + moved(0.12, 4.9, 0.5)},
                          rest_mm + cheek_offset);
  poses[2] = facing_probe({}, rest_mm + vec3(moved(0.8, 6.1, 0.3), 0, 0));
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
  lines[kMostBodies] = {
      .from_mm = line.from_mm - far_wall_.middle_mm, .along = line.along, .across = line.across};
  return lines;
}

BodyScene::Found BodyScene::at(const Lines& lines, float along_mm, float across_mm) const {
  const auto point = [&](const Line& line) {
    return line.from_mm + along_mm * line.along + across_mm * line.across;
  };
  Found found{.distance_mm = far_wall_.radius_mm - glm::length(point(lines[kMostBodies]))};
  for (std::size_t body = 0; body < bodies_.size(); ++body) {
    if (!lines[body].passes) {
      found.distance_mm = std::min(found.distance_mm, kNearMm - kMostAcrossMm);
      continue;
    }
    const float distance_mm = bodies_[body].surface->at(point(lines[body]));
    if (distance_mm < found.distance_mm) found = {distance_mm, bodies_[body].part, bodies_[body].has_bone};
  }
  if (near_wall_) {
    // What is thicker by a slope is nearer than it seems.
    constexpr float kSlope = 0.85F;
    const NearWall::Depth depth = near_wall_->depth(point(lines[kMostBodies]) + far_wall_.middle_mm);
    const float distance_mm = kSlope * (depth.below_mm - depth.end_mm);
    if (distance_mm < found.distance_mm)
      found = {distance_mm, Part::kNearWall, false, distance_mm < 0 ? NearWall::echo(depth) : 1.0F};
  }
  return found;
}

BodyScene::Found BodyScene::found(const Poses& poses, const vec3& at_mm) const {
  return at(in_bodies(poses, {.from_mm = at_mm}), 0, 0);
}

}  // namespace fanlight
