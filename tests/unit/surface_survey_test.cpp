// SPDX-License-Identifier: Apache-2.0
// The survey of a volume, on made volumes whose surface is known.
#include "renderer/survey/surface_survey.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "renderer/survey/auto_scene.hpp"
#include "renderer/survey/echo_survey.hpp"
#include "renderer/survey/ray_start.hpp"
#include "tests/support/made_volume.hpp"
#include "tests/support/survey_fan.hpp"

namespace fanlight::test {
namespace {

std::optional<SurfaceSurvey> found_in(const Volume& volume) {
  return find_surface(volume, measured_levels(volume));
}

/// A noise of the position: grey levels -6 to 6.
double noise(const Point& at) {
  return 6 * position_noise(at);
}

/// Bright tissue behind a plane through (0, 60, 0).
struct Tilted {
  double across;  ///< rise in y for each mm in x
  double up;      ///< and in z
};
Volume behind_plane(const Tilted& plane) {
  static Tilted tilt;
  tilt = plane;
  return made_volume(kSurveyFan, survey_angles(), [](const Point& at) {
    const double surface_mm = 60 + tilt.across * at.x_mm + tilt.up * at.z_mm;
    return (at.y_mm > surface_mm ? 140.0 : 20.0) + noise(at);
  });
}

TEST(SurfaceSurveyTest, FindsAPlaneAndItsNormal) {
  for (const Tilted tilt : {Tilted{0, 0}, Tilted{0.4, 0}, Tilted{0, -0.4}, Tilted{-0.3, 0.3}}) {
    const auto survey = found_in(behind_plane(tilt));
    ASSERT_TRUE(survey);
    const glm::dvec3 expected = glm::normalize(glm::dvec3(tilt.across, -1, tilt.up));
    EXPECT_GT(glm::dot(survey->normal, expected), std::cos(radians(3)));
    EXPECT_EQ(survey->sign, EdgeSign::kDarkToBright);
    EXPECT_GT(survey->covered_share, 0.7);
    EXPECT_GT(survey->found_share, 0.9);
    EXPECT_NEAR(survey->contrast, 120, 15);
    for (const glm::dvec3& point : survey->points)
      EXPECT_NEAR(point.y, 60 + tilt.across * point.x + tilt.up * point.z, 2.5);
  }
}

TEST(SurfaceSurveyTest, PassesOverLayersNextToTheProbe) {
  const Volume volume = made_volume(kSurveyFan, survey_angles(), [](const Point& at) {
    const double depth_mm = std::hypot(at.y_mm + 30, at.z_mm) - 30;
    if (depth_mm < 12) return 90 + 60 * std::sin(depth_mm) + noise(at);
    return (at.y_mm > 70 ? 150.0 : 15.0) + noise(at);
  });
  const auto survey = found_in(volume);
  ASSERT_TRUE(survey);
  EXPECT_NEAR(survey->centre.y, 70, 2);
}

TEST(SurfaceSurveyTest, FindsAPlaneWithoutAnyNoise) {
  const auto survey = found_in(
      made_volume(kSurveyFan, survey_angles(), [](const Point& at) { return at.y_mm > 60 ? 140.0 : 20.0; }));
  ASSERT_TRUE(survey);
  EXPECT_NEAR(survey->centre.y, 60, 2);
}

TEST(SurfaceSurveyTest, FindsFluidBehindTissueWhereThereIsNoOtherSheet) {
  const Volume volume = made_volume(
      kSurveyFan, survey_angles(), [](const Point& at) { return (at.y_mm > 60 ? 20.0 : 140.0) + noise(at); });
  const auto survey = found_in(volume);
  ASSERT_TRUE(survey);
  EXPECT_EQ(survey->sign, EdgeSign::kBrightToDark);
  EXPECT_NEAR(survey->centre.y, 60, 2);
  EXPECT_EQ(
      auto_scene(volume, scene_for(kSurveyFan, radians(-30), radians(30)), {512, 512})->scene.detector.sign,
      EdgeSign::kBrightToDark);
}

TEST(SurfaceSurveyTest, TakesTheFadingEchoOfAProbeInAirForNoSheet) {
  const Volume volume = made_volume(kSurveyFan, survey_angles(), [](const Point& at) {
    const double depth_mm = std::hypot(at.y_mm + 30, at.z_mm) - 30;
    return 220 * std::exp(-depth_mm / 5) + 6 + noise(at);
  });
  EXPECT_FALSE(found_in(volume));
}

TEST(SurfaceSurveyTest, FindsNothingWhereAStopIsRequested) {
  ASSERT_TRUE(found_in(behind_plane({0, 0})));
  std::stop_source stop;
  stop.request_stop();
  EXPECT_FALSE(find_surface(behind_plane({0, 0}), {}, stop.get_token()));
}

TEST(RayStartTest, LiesBeforeTheSheetAndBehindWhatIsBeforeIt) {
  EXPECT_EQ(best_start({}).found, 0U);
  const Start free = best_start({{-HUGE_VAL, 30}});
  EXPECT_EQ(free.found, 1U);
  EXPECT_EQ(free.depth_mm, 30 - kFinePartsMm);
  const Start behind = best_start({{22, 30}, {25, 31}, {20, 33}});
  EXPECT_EQ(behind.found, 3U);
  EXPECT_EQ(behind.depth_mm, 25);
  // Two sheets, one behind the other: the one in more rays.
  std::vector<StartRange> rays(10, StartRange{40, 50});
  rays.insert(rays.end(), 5, StartRange{-HUGE_VAL, 35});
  EXPECT_EQ(best_start(rays).found, 10U);
  EXPECT_EQ(best_start(rays).depth_mm, 40);
}

TEST(RayStartTest, GivesUpTheHundredthThatCostsTheMost) {
  std::vector<StartRange> rays(200, StartRange{10, 50});
  rays.push_back({48, 60});
  const Start start = best_start(rays);
  EXPECT_EQ(start.found, 201U);
  EXPECT_EQ(start.depth_mm, 50 - kFinePartsMm) << "one ray of 201 meets another echo first";
}

TEST(SurfaceSurveyTest, SurvivesASheetThatTurnsAwayFromTheView) {
  // A wall on the right side of the fan, which continues below: an L.
  for (const double wall_mm : {5.0, 15.0, 25.0}) {
    const Volume volume = made_volume(kSurveyFan, survey_angles(), [wall_mm](const Point& at) {
      return (at.x_mm > wall_mm + 0.3 * at.y_mm - 15 || at.y_mm > 85 ? 140.0 : 20.0) + 3 * noise(at);
    });
    const auto survey = found_in(volume);
    if (!survey) continue;
    EXPECT_LE(survey->found_share, 1);
    EXPECT_LT(std::abs(survey->start_mm), 200);
  }
}

TEST(SurfaceSurveyTest, FindsNothingInNoise) {
  const Volume volume =
      made_volume(kSurveyFan, survey_angles(), [](const Point& at) { return 60 + 3 * noise(at); });
  EXPECT_FALSE(found_in(volume));
}

TEST(SurfaceSurveyTest, FindsNothingInTheDark) {
  EXPECT_FALSE(found_in(made_volume(kSurveyFan, survey_angles(), [](const Point&) { return 0.0; })));
}

/// A head in fluid: an ellipsoid, turned, with a nose.
struct Head {
  glm::dvec3 centre;
  glm::dvec3 radii;
  double turn_rad;  // about y
  double tilt_rad;  // about x

  bool holds(const Point& point) const {
    glm::dvec3 at = glm::dvec3(point.x_mm, point.y_mm, point.z_mm) - centre;
    at = {at.x * std::cos(turn_rad) - at.z * std::sin(turn_rad), at.y,
          at.x * std::sin(turn_rad) + at.z * std::cos(turn_rad)};
    at = {at.x, at.y * std::cos(tilt_rad) - at.z * std::sin(tilt_rad),
          at.y * std::sin(tilt_rad) + at.z * std::cos(tilt_rad)};
    const glm::dvec3 nose = (at - glm::dvec3(0, -radii.y, 0)) / 8.0;
    return glm::dot(at / radii, at / radii) < 1 || glm::dot(nose, nose) < 1;
  }
};

/// A number from `low` to `high`.
double between(std::mt19937& bits, double low, double high) {
  return low + (high - low) * static_cast<double>(bits()) / 0x1p32;
}

TEST(SurfaceSurveyTest, FindsAHeadInNineteenOfTwentyPoses) {
  int found = 0;
  for (std::uint32_t seed = 0; seed < 20; ++seed) {
    std::mt19937 bits(seed);
    const Head head{.centre = {between(bits, -15, 15), between(bits, 75, 90), between(bits, -15, 15)},
                    .radii = {between(bits, 24, 34), between(bits, 24, 34), between(bits, 30, 42)},
                    .turn_rad = between(bits, -1.5, 1.5),
                    .tilt_rad = between(bits, -0.7, 0.7)};
    std::normal_distribution<double> speckle(0, 20);
    const Volume volume = made_volume(kSurveyFan, survey_angles(), [&](const Point& at) {
      return (head.holds(at) ? 140 : 8) + speckle(bits);
    });
    const auto survey = found_in(volume);
    if (!survey) continue;
    // The surface: no head a little before the point, and head a little behind it.
    int near = 0;
    for (const glm::dvec3& point : survey->points) {
      const auto at = [&](double behind_mm) {
        return head.holds({.x_mm = point.x, .y_mm = point.y + behind_mm, .z_mm = point.z});
      };
      near += !at(-4) && at(4) ? 1 : 0;
    }
    found += near >= 0.8 * static_cast<double>(survey->points.size()) ? 1 : 0;
  }
  EXPECT_GE(found, 19);
}

/// With the grey levels of real scans.
struct Levels {
  double fluid = 28;
  double body = 96;
  double wall = 96;
};

/// Fluid with a head and the wall of a uterus behind it.
Volume head_before_wall(const Head& head, bool casts_shadow, std::uint32_t seed, const Levels& levels = {}) {
  std::mt19937 bits(seed);
  std::normal_distribution<double> speckle(0, 16);
  return made_volume(kSurveyFan, survey_angles(), [&](const Point& at) {
    const double wall_mm = 104 + 4 * std::sin(at.x_mm / 17) - 0.003 * (at.x_mm * at.x_mm + at.z_mm * at.z_mm);
    // Where the beam to this point passes the middle of the head.
    const double beam_z_mm =
        at.z_mm * (head.centre.y + kSurveyFan.motor_radius_mm) / (at.y_mm + kSurveyFan.motor_radius_mm);
    const double aside =
        std::hypot((at.x_mm - head.centre.x) / head.radii.x, (beam_z_mm - head.centre.z) / head.radii.z);
    const bool in_shadow = casts_shadow && aside < 0.9 && at.y_mm > head.centre.y;
    if (in_shadow) return levels.fluid + speckle(bits) / 2;
    return (head.holds(at) ? levels.body : at.y_mm > wall_mm ? levels.wall : levels.fluid) + speckle(bits);
  });
}

/// Of these heads: found as bodies; and bodies that are no heads.
struct HeadsFound {
  int heads = 0;
  int others = 0;
};
HeadsFound heads_found(const Levels& levels, std::uint32_t heads = 20) {
  HeadsFound found;
  for (std::uint32_t seed = 0; seed < heads; ++seed) {
    std::mt19937 bits(seed);
    const Head head{.centre = {between(bits, -10, 10), between(bits, 55, 65), between(bits, -10, 10)},
                    .radii = {between(bits, 18, 26), between(bits, 18, 26), between(bits, 22, 30)},
                    .turn_rad = between(bits, -1.5, 1.5),
                    .tilt_rad = between(bits, -0.7, 0.7)};
    const auto survey = found_in(head_before_wall(head, seed % 2 == 0, seed, levels));
    if (!survey || !survey->is_body) continue;
    int on_head = 0;
    for (const glm::dvec3& point : survey->points)
      on_head += head.holds({.x_mm = point.x, .y_mm = point.y + 4, .z_mm = point.z}) ? 1 : 0;
    const bool is_head = on_head >= 0.8 * static_cast<double>(survey->points.size());
    ++(is_head ? found.heads : found.others);
  }
  return found;
}

TEST(SurfaceSurveyTest, PrefersABodyInFluidToTheWallBehindIt) {
  // A brighter wall: gas in a bowel, a sacrum.
  for (const Levels& levels : {Levels{}, Levels{.fluid = 8, .body = 140, .wall = 140}, Levels{.wall = 160},
                               Levels{.body = 110, .wall = 80}}) {
    const HeadsFound found = heads_found(levels);
    EXPECT_GE(found.heads, 19) << levels.wall;
    EXPECT_EQ(found.others, 0) << levels.wall;
  }
}

TEST(SurfaceSurveyTest, FindsABodyBeforeAWall) {
  EXPECT_EQ(heads_found({}, 1).heads, 1);
}

TEST(SurfaceSurveyTest, TakesALumpInTissueForNoBody) {
  const HeadsFound found = heads_found({.fluid = 64});
  EXPECT_EQ(found.heads + found.others, 0);
}

TEST(SurfaceSurveyTest, TakesAWallWithAPitOrALedgeForNoBody) {
  const auto is_body = [](const auto& depth_of_wall_mm) {
    std::mt19937 bits(3);
    std::normal_distribution<double> speckle(0, 16);
    const auto survey = found_in(made_volume(kSurveyFan, survey_angles(), [&](const Point& at) {
      return (at.y_mm > depth_of_wall_mm(at) ? 96 : 28) + speckle(bits);
    }));
    return survey && survey->is_body;
  };
  EXPECT_FALSE(is_body([](const Point& at) { return std::hypot(at.x_mm, at.z_mm) < 12 ? 95 : 60; }));
  for (const double ledge_mm : {-40, -20, 0, 10})
    EXPECT_FALSE(is_body([&](const Point& at) { return at.x_mm < ledge_mm ? 95 : 60; })) << ledge_mm;
  // A membrane before the wall.
  std::mt19937 bits(3);
  std::normal_distribution<double> speckle(0, 16);
  const auto survey = found_in(made_volume(kSurveyFan, survey_angles(), [&](const Point& at) {
    const bool membrane = at.x_mm > -5 && at.y_mm > 50 && at.y_mm < 54;
    return (membrane || at.y_mm > 75 ? 96 : 28) + speckle(bits);
  }));
  EXPECT_FALSE(survey->is_body);
}

TEST(SurfaceSurveyTest, TakesNoWallAndNoLayersForABody) {
  // A wall from one side to the other.
  EXPECT_FALSE(found_in(behind_plane({0.4, 0}))->is_body);
  // Layers of tissue that are dark in places, before a dome in tissue.
  const Volume layers = made_volume(kSurveyFan, survey_angles(), [](const Point& at) {
    const bool layer = at.y_mm > 16 && at.y_mm < 22 && std::sin(at.x_mm / 5) * std::cos(at.z_mm / 6) > -0.3;
    const double dome_mm = 90 - 0.01 * (at.x_mm * at.x_mm + at.z_mm * at.z_mm);
    const bool dome = at.y_mm > dome_mm && at.y_mm < dome_mm + 8;
    return (layer ? 120.0 : dome ? 160.0 : 60.0) + 2 * noise(at);
  });
  const auto survey = found_in(layers);
  ASSERT_TRUE(survey);
  EXPECT_FALSE(survey->is_body);
  EXPECT_GT(survey->centre.y, 70);
}

TEST(AutoSceneTest, ShowsTheOutlineOfABodyAndNotTheWallBehindIt) {
  const Head head{.centre = {0, 60, 0}, .radii = {22, 22, 26}, .turn_rad = 0.3, .tilt_rad = 0.2};
  const auto made = auto_scene(head_before_wall(head, true, 1),
                               scene_for(kSurveyFan, radians(-30), radians(30)), {512, 512});
  ASSERT_TRUE(made);
  EXPECT_TRUE(made->is_sure);
  const ViewFrame view = view_frame(made->scene.camera);
  const auto depth_mm = [&](const glm::dvec3& at) { return glm::dot(at - view.centre, view.forward); };
  EXPECT_LT(made->scene.rays.start_mm, depth_mm({0, 36, 0}));
  EXPECT_GT(made->scene.rays.end_mm, depth_mm({0, 58, 0}));
  EXPECT_LT(made->scene.rays.end_mm, depth_mm({0, 100, 0}));
  EXPECT_GT(made->scene.camera.field_mm, 2 * 26);
}

TEST(AutoSceneTest, LooksAtThePlaneAtARightAngleFromJustBeforeIt) {
  const Scene base = scene_for(kSurveyFan, radians(-30), radians(30));
  const auto made = auto_scene(behind_plane({0.4, 0}), base, {512, 512});
  ASSERT_TRUE(made);
  const ViewFrame view = view_frame(made->scene.camera);
  EXPECT_GT(glm::dot(view.forward, glm::normalize(glm::dvec3(-0.4, 1, 0))), std::cos(radians(4)));
  // Nothing lies before the plane, so there is room for fine parts; all of it is before the end of the rays.
  const double depth_mm = glm::dot(glm::dvec3(0, 60, 0) - view.centre, view.forward);
  EXPECT_NEAR(depth_mm, kSurveyWindowMm + kFinePartsMm, 3);
  EXPECT_GT(made->scene.rays.end_mm, depth_mm + 5);
  EXPECT_TRUE(check(made->scene));
  EXPECT_GE(made->choices.size(), 4U);
  // The same volume gives the same scene.
  const auto again = auto_scene(behind_plane({0.4, 0}), base, {512, 512});
  EXPECT_EQ(first_pass_changed(made->scene, again->scene), FirstPass::kNone);
}

TEST(AutoSceneTest, BeginsTheRaysBehindAnEchoBeforeTheSheet) {
  // A narrow bright layer 9 mm before the tissue, over half of its width.
  const Volume volume = made_volume(kSurveyFan, survey_angles(), [](const Point& at) {
    const bool layer = at.x_mm > 0 && at.y_mm > 51 && at.y_mm < 54;
    return (at.y_mm > 60 || layer ? 140.0 : 20.0) + noise(at);
  });
  const auto made = auto_scene(volume, scene_for(kSurveyFan, radians(-30), radians(30)), {512, 512});
  ASSERT_TRUE(made);
  const ViewFrame view = view_frame(made->scene.camera);
  const double first_mm = glm::dot(glm::dvec3(0, 60, 0) - view.centre, view.forward) - kSurveyWindowMm;
  EXPECT_GE(first_mm, 0) << "the plane itself is passed over";
  EXPECT_LT(first_mm, 9) << "the layer is found instead";
}

TEST(AutoSceneTest, SaysThatThereIsNoSurface) {
  const Volume volume =
      made_volume(kSurveyFan, survey_angles(), [](const Point& at) { return 60 + noise(at); });
  EXPECT_FALSE(auto_scene(volume, scene_for(kSurveyFan, radians(-30), radians(30)), {512, 512}));
}

}  // namespace
}  // namespace fanlight::test
