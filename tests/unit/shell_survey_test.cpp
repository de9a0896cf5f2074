// SPDX-License-Identifier: Apache-2.0
// A closed bright shell in made volumes, as a fetal skull that touches the tissue before it.
#include "renderer/survey/shell_survey.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "proto/model/preset.hpp"
#include "renderer/survey/auto_scene.hpp"
#include "renderer/survey/near_tissue_survey.hpp"
#include "tests/support/made_volume.hpp"
#include "tests/support/survey_fan.hpp"

namespace fanlight::test {
namespace {

double head_noise(const Point& at) {
  return 8 * position_noise(at);
}

// Half axes of an ellipsoid: lateral, into the body, elevation.
constexpr double kHalfX = 34;
constexpr double kHalfY = 26;
constexpr double kHalfZ = 28;
constexpr double kMiddleY = 42;
constexpr double kBoneMm = 3;

/// From the outer side of the shell inwards, mm; near the shell.
double inside_mm(const Point& at) {
  const double share = std::hypot(at.x_mm / kHalfX, (at.y_mm - kMiddleY) / kHalfY, at.z_mm / kHalfZ);
  return (1 - share) * kHalfY;
}

/// Tissue about a bone of 3 mm, and a dark brain with a bright line in its middle.
double head(const Point& at) {
  const double depth_mm = inside_mm(at);
  if (depth_mm < 0) return 110 + head_noise(at);
  if (depth_mm < kBoneMm) return 170 + head_noise(at);
  return (std::abs(at.y_mm - kMiddleY) < 1 && std::abs(at.z_mm) < 15 ? 110 : 50) + head_noise(at);
}

/// Where the straight line into the body at (x, z) meets the shell first; NAN: it passes by.
double near_side_mm(double x_mm, double z_mm) {
  const double rest = 1 - std::pow(x_mm / kHalfX, 2) - std::pow(z_mm / kHalfZ, 2);
  return rest > 0 ? kMiddleY - kHalfY * std::sqrt(rest) : NAN;
}

TEST(ShellSurveyTest, FindsTheNearWallOfAHeadThatTouchesTheTissueBeforeIt) {
  const Volume volume = made_volume(kSurveyFan, survey_angles(), head);
  const auto shell = find_shell(volume);
  ASSERT_TRUE(shell);
  // The sphere goes through the inner sides.
  EXPECT_NEAR(shell->radius_mm, (kHalfX + kHalfY + kHalfZ) / 3 - kBoneMm, 3);
  EXPECT_EQ(shell->near_wall.sign, EdgeSign::kBrightToDark);
  EXPECT_GT(shell->near_wall.found_share, 0.9);
  int judged = 0;
  for (const glm::dvec3& point : shell->near_wall.points) {
    const double near_mm = near_side_mm(point.x, point.z);
    if (std::hypot(point.x / kHalfX, point.z / kHalfZ) > 0.6) continue;
    ++judged;
    EXPECT_NEAR(point.y, near_mm + kBoneMm, 3) << point.x << ", " << point.z;
  }
  EXPECT_GT(judged, 100);
}

TEST(ShellSurveyTest, EndsWhatLiesBeforeItBeforeTheBone) {
  const Volume volume = made_volume(kSurveyFan, survey_angles(), head);
  const auto shell = find_shell(volume);
  ASSERT_TRUE(shell);
  for (const double x_mm : {-15.0, 0.0, 15.0}) {
    const double end_mm = shell->before.end_row_at(kSurveyFan, kSurveyFan.face_column + x_mm, 0);
    EXPECT_LT(end_mm, near_side_mm(x_mm, 0) + 1) << x_mm;
    EXPECT_GT(end_mm, near_side_mm(x_mm, 0) - 5) << x_mm;
  }
}

TEST(ShellSurveyTest, IsNotFoundInWhatIsNoShell) {
  // A bowl before nothing, a ball in fluid, and tissue alone.
  const auto bowl = [](const Point& at) {
    return (at.y_mm > kMiddleY && inside_mm(at) < kBoneMm ? 150.0 : 30.0) + head_noise(at);
  };
  const auto ball = [](const Point& at) { return (inside_mm(at) > 0 ? 150.0 : 20.0) + head_noise(at); };
  const auto tissue = [](const Point& at) { return 110 + head_noise(at); };
  // As a liver before the diaphragm: near tissue that bends about the probe.
  const auto organ = [](const Point& at) {
    const double depth_mm = std::hypot(at.x_mm, at.y_mm + 50, at.z_mm) - 50;
    const bool is_dark = depth_mm > 18 && (at.y_mm < kMiddleY || inside_mm(at) > kBoneMm);
    return (is_dark ? 40.0 : 130.0) + head_noise(at);
  };
  // A bladder, or a sac: behind it the tissue stays bright.
  const auto cavity = [](const Point& at) { return (inside_mm(at) > 0 ? 20.0 : 110.0) + head_noise(at); };
  EXPECT_FALSE(find_shell(made_volume(kSurveyFan, survey_angles(), organ)));
  EXPECT_FALSE(find_shell(made_volume(kSurveyFan, survey_angles(), cavity)));
  EXPECT_FALSE(find_shell(made_volume(kSurveyFan, survey_angles(), bowl)));
  EXPECT_FALSE(find_shell(made_volume(kSurveyFan, survey_angles(), ball)));
  EXPECT_FALSE(find_shell(made_volume(kSurveyFan, survey_angles(), tissue)));
}

TEST(ShellSurveyTest, NeedsMoreThanAFewFrames) {
  for (const int frames : {1, 2, 3}) {
    std::vector<double> angles_rad;
    for (int frame = 0; frame < frames; ++frame) angles_rad.push_back(0.05 * frame);
    EXPECT_FALSE(find_shell(made_volume(kSurveyFan, angles_rad, head))) << frames;
  }
}

TEST(ShellSurveyTest, IsWhatTheAutomaticSceneShows) {
  const Volume volume = made_volume(kSurveyFan, survey_angles(), head);
  const auto made = auto_scene(volume, scene_for(kSurveyFan, radians(-30), radians(30)), {512, 512});
  ASSERT_TRUE(made);
  EXPECT_EQ(made->scene.near.before_bone, NearTissueShow::kRemoved);
  EXPECT_EQ(made->scene.detector.sign, EdgeSign::kBrightToDark);
  EXPECT_LT(std::abs(made->scene.camera.yaw_deg), 15);

  // What a preset for bone has set is not kept where there is no bone.
  Scene bone = scene_for(kSurveyFan, radians(-30), radians(30));
  apply_preset(bone, *std::ranges::find(presets(), "bone", &Preset::name));
  const auto plane = auto_scene(
      made_volume(kSurveyFan, survey_angles(), [](const Point& at) { return at.y_mm > 60 ? 140.0 : 20.0; }),
      bone, {512, 512});
  ASSERT_TRUE(plane);
  EXPECT_EQ(plane->scene.near.before_bone, NearTissueShow::kShown);
  EXPECT_EQ(plane->scene.detector.place, SurfacePlace::kLevel);
}

TEST(ShellSurveyTest, IsSearchedForWhereASceneRemovesWhatLiesBeforeIt) {
  const Volume volume = made_volume(kSurveyFan, survey_angles(), head);
  Scene::Near near{.before_bone = NearTissueShow::kRemoved};
  const NearTissueSearch found = search_near_tissue(volume, {}, near);
  EXPECT_EQ(found.state(near), NearTissueState::kRemovedToBone);
  EXPECT_NE(found.removed_by(near), nullptr);
  // Another scene of the same volume, which removes only what lies before fluid, shows it.
  const Scene::Near to_fluid{.tissue = NearTissueShow::kRemoved};
  EXPECT_EQ(found.removed_by(to_fluid), nullptr);
  EXPECT_EQ(found.state({}), NearTissueState::kShown);

  const Volume tissue =
      made_volume(kSurveyFan, survey_angles(), [](const Point& at) { return 110 + head_noise(at); });
  EXPECT_EQ(search_near_tissue(tissue, {}, near).state(near), NearTissueState::kNoBone);
}

}  // namespace
}  // namespace fanlight::test
