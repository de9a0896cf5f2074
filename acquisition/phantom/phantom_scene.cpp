// SPDX-License-Identifier: Apache-2.0
#include "acquisition/phantom/phantom_scene.hpp"

#include <algorithm>
#include <cmath>

#include "acquisition/phantom/sway.hpp"
#include "proto/model/fan_geometry.hpp"

namespace fanlight {

namespace {

// The relief is a grid that covers +-kReachMm in both directions. Beyond the head it holds kNoSurfaceMm, so
// points outside the grid read its border. The bilinear interpolation of the grid is the exact surface: tests
// compare with it.
constexpr int kNodes = 257;
constexpr double kReachMm = 64;
constexpr double kNodesPerMm = (kNodes - 1) / (2 * kReachMm);

// Head without its features: half of an ellipsoid, its pole towards the probe.
constexpr double kHeadHalfWidthMm = 54;
constexpr double kHeadHalfHeightMm = 59;
constexpr double kHeadPoleMm = 90;
constexpr double kHeadHalfDepthMm = 38;

/// A feature: a Gaussian bump (negative depth: towards the probe) or hollow.
struct Feature {
  double depth_mm;
  double u_mm;  // to the side; a feature off the middle is mirrored
  double v_mm;  // up
  double width_mm;
  double height_mm;
};

constexpr Feature kFace[] = {
    {-4.0, 0, 29, 27, 15},         // forehead
    {-2.2, 17, 14, 10, 4},         // brow
    {6.5, 18.5, 4, 9, 6.5},        // eye socket
    {-5.2, 18.5, 3.2, 6.6, 4.6},   // eye, closed
    {1.4, 18.5, 0.6, 6.4, 1.0},    // its lid's edge
    {-2.6, 0, 8, 4, 7},            // bridge of the nose
    {-4.6, 0, -1.5, 4.6, 5.5},     //
    {-8.5, 0, -8, 5.4, 4.6},       // tip of the nose
    {-4.8, 7, -9.8, 3.8, 3.4},     // wing of the nose
    {3.6, 3.5, -13, 1.8, 1.4},     // nostril
    {-4.0, 0, -25, 17, 11},        // mouth region
    {1.1, 0, -18, 1.7, 3.2},       // philtrum
    {-4.2, 3.4, -22.4, 5.2, 2.3},  // upper lip
    {3.0, 0, -26, 7.5, 1.0},       // line of the mouth
    {-5.0, 0, -29.8, 6.8, 2.8},    // lower lip
    {1.8, 0, -35.5, 9, 2.6},       // crease below it
    {-7.0, 0, -42.5, 10, 6.5},     // chin
    {-7.5, 26, -15, 12, 12},       // cheek
};
constexpr Feature kOpenMouth = {7.0, 0, -26.0, 5.8, 2.4};

double value(const Feature& feature, double u_mm, double v_mm) {
  const double across = (u_mm - feature.u_mm) / feature.width_mm;
  const double along = (v_mm - feature.v_mm) / feature.height_mm;
  return feature.depth_mm * std::exp(-0.5 * (across * across + along * along));
}

double relief_mm(double u_mm, double v_mm) {
  const double across = u_mm / kHeadHalfWidthMm;
  const double along = v_mm / kHeadHalfHeightMm;
  const double radius_squared = across * across + along * along;
  if (radius_squared >= 1) return PhantomScene::kNoSurfaceMm;
  double depth_mm = kHeadPoleMm + kHeadHalfDepthMm * (1 - std::sqrt(1 - radius_squared));
  for (const Feature& feature : kFace) {
    depth_mm += value(feature, u_mm, v_mm);
    if (feature.u_mm != 0) depth_mm += value(feature, -u_mm, v_mm);
  }
  return depth_mm;
}

constexpr double kBobMm = 2.5;
constexpr double kDriftMm = 3;
constexpr double kTurn = 0.13;
constexpr double kNod = 0.10;

}  // namespace

PhantomScene::PhantomScene(Motion motion) : motion_(motion), nodes_(std::size_t{kNodes} * kNodes) {
  double nearest_mm = kNoSurfaceMm;
  for (int row = 0; row < kNodes; ++row) {
    for (int column = 0; column < kNodes; ++column) {
      const double u_mm = column / kNodesPerMm - kReachMm;
      const double v_mm = row / kNodesPerMm - kReachMm;
      const double depth_mm = relief_mm(u_mm, v_mm);
      nodes_[row * kNodes + column] = {static_cast<float>(depth_mm),
                                       static_cast<float>(value(kOpenMouth, u_mm, v_mm))};
      const double tilted_mm = depth_mm - kTurn * std::abs(u_mm) - kNod * std::abs(v_mm);
      nearest_mm = std::min(nearest_mm, tilted_mm);
    }
  }
  nearest_depth_mm_ = nearest_mm - kBobMm;
}

PhantomScene::Pose PhantomScene::pose_at(double time_s) const {
  if (motion_ == Motion::kStill) return {};
  const double roll_rad = sway(radians(5), 9.1, 0.1, time_s);
  return {.shift_x_mm = sway(kDriftMm, 6.7, 0, time_s),
          .shift_y_mm = sway(kBobMm, 4.3, 0.2, time_s),
          .shift_z_mm = sway(kDriftMm, 5.9, 0.4, time_s),
          .roll_cosine = std::cos(roll_rad),
          .roll_sine = std::sin(roll_rad),
          .turn_mm_per_mm = sway(kTurn, 7.3, 0.05, time_s),
          .nod_mm_per_mm = sway(kNod, 5.3, 0.3, time_s),
          .mouth = 0.5 + sway(0.5, 3.7, 0, time_s)};
}

double PhantomScene::surface_depth_mm(double x_mm, double z_mm, double time_s) const {
  constexpr float kAcross[] = {1};
  constexpr float kAhead[] = {0};
  float depth_mm = 0;
  surface_row_mm(pose_at(time_s), {.across = kAcross, .ahead = kAhead, .x_mm = x_mm, .z_mm = z_mm},
                 {&depth_mm, 1});
  return depth_mm;
}

void PhantomScene::surface_row_mm(const Pose& pose, const Row& points, std::span<float> depths_mm) const {
  // Linear functions of across and ahead, before the grid is read.
  struct Linear {
    float offset;
    float per_across;
    float per_ahead;
    float at(float across, float ahead) const { return offset + across * per_across + ahead * per_ahead; }
  };
  const auto linear = [&](double per_x_mm, double per_z_mm, double offset) {
    const double from_pose = offset - per_x_mm * pose.shift_x_mm + per_z_mm * (points.z_mm - pose.shift_z_mm);
    return Linear{static_cast<float>(from_pose), static_cast<float>(per_x_mm * points.x_mm),
                  static_cast<float>(per_z_mm * points.ahead_z_mm)};
  };
  // The face's own axes: u to its left, v up.
  const double grid_cosine = kNodesPerMm * pose.roll_cosine;
  const double grid_sine = kNodesPerMm * pose.roll_sine;
  const Linear to_u = linear(grid_cosine, grid_sine, kReachMm * kNodesPerMm);
  const Linear to_v = linear(-grid_sine, grid_cosine, kReachMm * kNodesPerMm);
  const Linear to_plane =
      linear(pose.turn_mm_per_mm * pose.roll_cosine - pose.nod_mm_per_mm * pose.roll_sine,
             pose.turn_mm_per_mm * pose.roll_sine + pose.nod_mm_per_mm * pose.roll_cosine, pose.shift_y_mm);
  const auto mouth = static_cast<float>(pose.mouth);

  constexpr float kLast = kNodes - 1.001F;  // the last cell needs a node on its far side
  const Node* const nodes = nodes_.data();
  for (std::size_t i = 0; i < depths_mm.size(); ++i) {
    const float across = points.across[i];
    const float ahead = points.ahead[i];
    const float u = std::clamp(to_u.at(across, ahead), 0.0F, kLast);
    const float v = std::clamp(to_v.at(across, ahead), 0.0F, kLast);
    const int column = static_cast<int>(u);
    const int row = static_cast<int>(v);
    const float right = u - static_cast<float>(column);
    const float up = v - static_cast<float>(row);
    const auto depth = [&](const Node& node) { return node.relief_mm + mouth * node.mouth_mm; };
    const Node* const cell = &nodes[row * kNodes + column];
    const float below = depth(cell[0]) + right * (depth(cell[1]) - depth(cell[0]));
    const float above = depth(cell[kNodes]) + right * (depth(cell[kNodes + 1]) - depth(cell[kNodes]));
    depths_mm[i] = below + up * (above - below) + to_plane.at(across, ahead);
  }
}

}  // namespace fanlight
