// SPDX-License-Identifier: Apache-2.0
// Grey levels from the data, and what a scene takes from them.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "renderer/parameters/effective_scene.hpp"
#include "renderer/survey/echo_survey.hpp"
#include "tests/support/made_volume.hpp"

namespace fanlight::test {
namespace {

const FanGeometry kHalfMmGeometry{.columns = 140,
                                  .rows = 168,
                                  .pixel_width_mm = 0.5,
                                  .pixel_height_mm = 0.5,
                                  .face_column = 69.5,
                                  .face_row = 0,
                                  .motor_radius_mm = 30};
const std::vector<double> kFiveAnglesRad = {-0.2, -0.1, 0, 0.1, 0.2};

/// Tissue below 50 mm.
template <typename Grey>
Volume half_filled(Grey grey) {
  return made_volume(kHalfMmGeometry, kFiveAnglesRad, [&](const Point& at) { return grey(at.y_mm > 50); });
}

Volume log_compressed() {
  std::mt19937 bits(3);
  std::normal_distribution<double> speckle(0, 20);
  return half_filled([&](bool tissue) { return (tissue ? 140 : 8) + speckle(bits); });
}

Volume not_compressed() {
  std::mt19937 bits(3);
  std::weibull_distribution<double> rayleigh(2, 2 / std::sqrt(kPi));  // of mean 1
  return half_filled([&](bool tissue) { return (tissue ? 90 : 6) * rayleigh(bits); });
}

TEST(EchoLevelsTest, OfLogCompressedFrames) {
  const EchoLevels levels = measured_levels(log_compressed());
  EXPECT_TRUE(levels.known);
  EXPECT_NEAR(levels.fluid, 12, 4) << "black cuts half of the speckle off";
  EXPECT_NEAR(levels.tissue, 140, 3);
  EXPECT_NEAR(levels.noise, 20, 2);
  EXPECT_FALSE(levels.linear());
  EXPECT_NEAR(levels.threshold(), 0.16 * 128, 2);
}

TEST(EchoLevelsTest, OfFramesThatAreNotCompressed) {
  const EchoLevels levels = measured_levels(not_compressed());
  EXPECT_NEAR(levels.tissue, 90, 5);
  EXPECT_NEAR(levels.noise / levels.tissue, 0.5, 0.07);
  EXPECT_TRUE(levels.linear());
}

TEST(EchoLevelsTest, AreUnknownWhereTheFramesShowNothing) {
  EXPECT_FALSE(measured_levels(half_filled([](bool) { return 0; })).known);
  EXPECT_FALSE(measured_levels(half_filled([](bool) { return 77; })).known);
}

TEST(EchoLevelsTest, StayOutsideTheSectorOut) {
  FanGeometry sector = kHalfMmGeometry;
  sector.probe_radius_mm = 20;
  sector.sector = {.half_angle_deg = 20, .reach_mm = 90};
  const Volume volume = made_volume(sector, kFiveAnglesRad, [&](const Point& at) {
    const double rho_mm = std::hypot(at.y_mm + 30, at.z_mm) - 30;  // depth in its frame
    const double across_deg = degrees(std::atan2(std::abs(at.x_mm), rho_mm + 20));
    return across_deg > 20 ? 0 : rho_mm > 40 ? 150 : 60;
  });
  EXPECT_NEAR(measured_levels(volume).fluid, 60, 2) << "not the black border";
}

TEST(EchoLevelsTest, AreFlatWhereTheEchoIsSpeckleAlone) {
  std::mt19937 bits(3);
  std::normal_distribution<double> speckle(0, 20);
  for (const double mean : {25, 140}) {
    const EchoLevels levels = measured_levels(half_filled([&](bool) { return mean + speckle(bits); }));
    EXPECT_TRUE(levels.flat) << mean;
    EXPECT_FALSE(levels.known) << mean;
    EXPECT_GT(levels.threshold(), 100) << "no step is a surface";
  }
  EXPECT_FALSE(measured_levels(log_compressed()).flat);
  EXPECT_FALSE(measured_levels(not_compressed()).flat);
}

/// Reverberation below the probe: 210 at its face, 8 grey levels less each mm.
double reverberation(const Point& at) {
  const double depth_mm = std::hypot(at.y_mm + 30, at.z_mm) - 30;
  return 210 - 8 * depth_mm;
}

TEST(EchoLevelsTest, LeaveReverberationOut) {
  std::mt19937 bits(3);
  std::normal_distribution<double> speckle(0, 20);
  const auto levels_of = [&](auto tissue) {
    return measured_levels(made_volume(kHalfMmGeometry, kFiveAnglesRad, [&](const Point& at) {
      return std::max(reverberation(at), tissue(at) ? 120.0 : 30.0) + speckle(bits);
    }));
  };
  // A ball, so that less of the volume is tissue than reverberation.
  const EchoLevels ball =
      levels_of([](const Point& at) { return std::hypot(at.x_mm, at.y_mm - 55, at.z_mm) < 15; });
  EXPECT_TRUE(ball.known);
  EXPECT_NEAR(ball.tissue, 120, 8);
  EXPECT_NEAR(ball.fluid, 30, 5);
  EXPECT_TRUE(levels_of([](const Point&) { return false; }).flat) << "nothing but noise below it";
}

TEST(EchoLevelsTest, CountTissueThatBeginsAtTheProbe) {
  std::mt19937 bits(3);
  std::normal_distribution<double> speckle(0, 20);
  const EchoLevels levels =
      measured_levels(made_volume(kHalfMmGeometry, kFiveAnglesRad, [&](const Point& at) {
        return (at.y_mm < 60 ? 130 : 20) + speckle(bits);
      }));
  EXPECT_TRUE(levels.known);
  EXPECT_NEAR(levels.tissue, 130, 5);
}

TEST(EchoLevelsTest, CountASlabNextToTheProbe) {
  std::mt19937 bits(3);
  std::normal_distribution<double> speckle(0, 20);
  // Layers of 3.5 mm: eight may be left out.
  for (const double end_mm : {9.0, 20.0, 27.0, 30.0, 34.0}) {
    const EchoLevels levels =
        measured_levels(made_volume(kHalfMmGeometry, kFiveAnglesRad, [&](const Point& at) {
          const double depth_mm = std::hypot(at.y_mm + 30, at.z_mm) - 30;
          return (depth_mm < end_mm ? 130 : 40) + speckle(bits);
        }));
    EXPECT_TRUE(levels.known) << end_mm;
    EXPECT_NEAR(levels.tissue, 130, 5) << end_mm;
  }
}

TEST(EchoLevelsTest, FindASmallBallInSpeckle) {
  const std::vector<double> near_angles_rad = {-0.05, 0, 0.05};
  std::mt19937 bits(3);
  std::normal_distribution<double> speckle(0, 15);
  const EchoLevels levels =
      measured_levels(made_volume(kHalfMmGeometry, near_angles_rad, [&](const Point& at) {
        return (std::hypot(at.x_mm - 12, at.y_mm - 50, at.z_mm) < 5 ? 150 : 45) + speckle(bits);
      }));
  EXPECT_TRUE(levels.known);
  EXPECT_NEAR(levels.fluid, 45, 4);
  EXPECT_GT(levels.tissue, 100) << "blocks on its border are darker";
  EXPECT_NEAR(levels.noise, 15, 3);
}

TEST(EchoLevelsTest, RiseByTheSpecklesDecibels) {
  const auto rise = [](double noise) {
    return EchoLevels{.fluid = 10, .tissue = 170, .noise = noise, .known = true}.rise(0);
  };
  EXPECT_NEAR(rise(23.7), 0.777, 0.002) << "60 dB from black to white";
  EXPECT_NEAR(rise(40), 0.623, 0.002) << "36 dB";
  EXPECT_EQ(rise(1), 0.83) << "a scanner that smooths is not taken for one of endless range";
  const EchoLevels usual{.fluid = 10, .tissue = 170, .noise = 23.7, .known = true};
  EXPECT_NEAR(usual.rise(0.6), 0.734, 0.002) << "10 dB below the tissue, where the reach makes up for it";
  EXPECT_EQ(usual.rise(1), usual.rise(0.6));
}

TEST(EchoLevelsTest, TakeAThinSheetForNoSpeckle) {
  std::mt19937 bits(3);
  std::normal_distribution<double> speckle(0, 20);
  const EchoLevels levels =
      measured_levels(made_volume(kHalfMmGeometry, kFiveAnglesRad, [&](const Point& at) {
        return at.y_mm > 50 && at.y_mm < 51.5 ? 160 + speckle(bits) : 10.0;
      }));
  EXPECT_TRUE(levels.known);
  EXPECT_FALSE(levels.linear());
  EXPECT_NEAR(levels.noise, 20, 7) << "most of these blocks differ by the sheet, 60 from row to row";
}

TEST(EchoLevelsTest, AreNotFlatOfASmallBallInCleanFluid) {
  for (const double fluid : {0.0, 5.0, 30.0}) {
    for (const double radius_mm : {2.0, 4.0, 7.0}) {
      const EchoLevels levels =
          measured_levels(made_volume(kHalfMmGeometry, kFiveAnglesRad, [=](const Point& at) {
            return std::hypot(at.x_mm - 12, at.y_mm - 50, at.z_mm) < radius_mm ? 200.0 : fluid;
          }));
      EXPECT_FALSE(levels.flat) << fluid << ", " << radius_mm << " mm: " << levels.fluid << " "
                                << levels.tissue << " " << levels.noise;
    }
  }
}

TEST(SteadyLevelsTest, TakeAFirstVolumeThatIsFlat) {
  const EchoLevels flat{.fluid = 100, .tissue = 110, .noise = 20, .flat = true};
  SteadyLevels steady;
  EXPECT_TRUE(steady.is_other(flat)) << "in force before its own picture";
  steady.add(flat);
  EXPECT_TRUE(steady.in_force().flat);
  EXPECT_FALSE(steady.is_other(flat));
}

TEST(SteadyLevelsTest, GiveUpAfterThreeFlatVolumes) {
  const EchoLevels known{.fluid = 10, .tissue = 110, .noise = 20, .known = true};
  EchoLevels flat = known;
  flat.known = false;
  flat.flat = true;
  SteadyLevels steady;
  steady.add(flat);
  EXPECT_TRUE(steady.in_force().flat) << "nothing else is known";
  steady.add(known);
  EXPECT_EQ(steady.in_force(), known);
  steady.add(flat);
  steady.add(flat);
  EXPECT_EQ(steady.in_force(), known) << "the probe may have slipped for a moment";
  steady.add(flat);
  EXPECT_TRUE(steady.in_force().flat);
  steady.add(known);
  EXPECT_EQ(steady.in_force(), known) << "at once";
}

TEST(SteadyLevelsTest, FollowSlowlyAndInSteps) {
  const EchoLevels first{.fluid = 10, .tissue = 110, .noise = 20, .known = true};
  SteadyLevels steady;
  EXPECT_FALSE(steady.in_force().known);
  steady.add({});
  EXPECT_FALSE(steady.in_force().known);
  steady.add(first);
  EXPECT_EQ(steady.in_force(), first);
  EchoLevels little = first;
  little.tissue = 115;
  for (int volume = 0; volume < 50; ++volume) steady.add(little);
  EXPECT_EQ(steady.in_force(), first) << "5 % are no reason to prepare the frames again";
  EchoLevels more = first;
  more.tissue = 155;
  EXPECT_FALSE(steady.is_other(more));
  for (int volume = 0; volume < 3; ++volume) steady.add(more);
  EXPECT_GT(steady.in_force().tissue, 120);
  EXPECT_LT(steady.in_force().tissue, 150) << "not the whole way yet";
  for (int volume = 0; volume < 50; ++volume) steady.add(more);
  EXPECT_NEAR(steady.in_force().tissue, 155, 15);
  EchoLevels brighter = first;
  brighter.fluid += 100;
  brighter.tissue += 100;
  EXPECT_TRUE(steady.is_other(brighter)) << "fluid is now as bright as the least tissue was";
  EchoLevels other = first;
  other.noise = 3;
  EXPECT_TRUE(steady.is_other(other));
  steady.add(other);
  EXPECT_EQ(steady.in_force(), other) << "another gain, or another recording";
  steady.add({});
  EXPECT_EQ(steady.in_force(), other) << "a volume that shows nothing tells nothing";
}

TEST(EffectiveSceneTest, TurnsMillimetresIntoSamplesAndPixels) {
  Scene scene;
  scene.rays.end_mm = 80;
  scene.detector.window_mm = 6;
  scene.speckle.size_mm = 2.2;
  scene.filter.size_mm = 6.5;
  scene.camera.field_mm = 100;
  const Scene made = effective_scene(scene, kHalfMmGeometry, {512, 200}, {});
  EXPECT_EQ(made.rays.step_mm, 0.5);
  EXPECT_EQ(made.detector.window, 12);
  EXPECT_EQ(made.speckle.size, 5);
  EXPECT_EQ(made.filter.size, 13);
  scene.camera.field_mm = 10;
  EXPECT_EQ(effective_scene(scene, kHalfMmGeometry, {512, 200}, {}).filter.size, 31) << "the widest there is";
}

TEST(EffectiveSceneTest, CountsThePixelsOfThePartThatShowsTheSurface) {
  Scene scene;
  scene.camera.field_mm = 100;
  scene.filter.size_mm = 6.4;
  scene.mode = Mode::kSlices;
  EXPECT_EQ(effective_scene(scene, kHalfMmGeometry, {400, 400}, {}).filter.size, 13) << "half as high";
  scene.mode = Mode::kSurface;
  EXPECT_EQ(effective_scene(scene, kHalfMmGeometry, {400, 400}, {}).filter.size, 25);
}

TEST(EffectiveSceneTest, LeavesTheStepWhereNoSurfaceIsWanted) {
  Scene scene;
  scene.mode = Mode::kMaximum;
  scene.detector.window_mm = 40;
  EXPECT_EQ(effective_scene(scene, kHalfMmGeometry, {512, 512}, {}).rays.step_mm, 0.5);
}

TEST(EffectiveSceneTest, WidensTheStepUntilTheWindowFits) {
  Scene scene;
  scene.rays.end_mm = 40;
  scene.detector.window_mm = 8;
  FanGeometry fine = kHalfMmGeometry;
  fine.pixel_width_mm = fine.pixel_height_mm = 0.08;
  const Scene made = effective_scene(scene, fine, {512, 512}, {});
  EXPECT_EQ(made.rays.step_mm, 0.25);
  EXPECT_EQ(made.detector.window, 32);
  scene.rays.step_mm = 0.1;
  EXPECT_EQ(effective_scene(scene, fine, {512, 512}, {}).rays.step_mm, 0.1) << "the user's step stays";
}

TEST(EffectiveSceneTest, TakesThresholdAndNoiseFromTheData) {
  Scene scene;
  scene.detector.threshold = 0;
  scene.speckle.noise = 0;
  scene.detector.reach = 0.6;
  const EchoLevels log{.fluid = 10, .tissue = 110, .noise = 18, .known = true};
  const Scene made = effective_scene(scene, kHalfMmGeometry, {512, 512}, log);
  EXPECT_EQ(made.detector.threshold, 16);
  EXPECT_EQ(effective_scene(scene, kHalfMmGeometry, {512, 512},
                            {.fluid = 10, .tissue = 90, .noise = 24, .known = true})
                .detector.threshold,
            0.65 * 24)
      << "no less than the speckle that is left";
  EXPECT_NEAR(made.detector.rise, 1 - 10 * 18 / 5.57 / 100, 1e-9) << "10 dB below the tissue";
  EXPECT_NEAR(made.detector.sheet_below, 4.2 * 18 / 5.57, 1e-9) << "of a sheet 4.2 dB below its peak";
  EXPECT_EQ(made.detector.least_tissue, 50);
  EXPECT_EQ(made.detector.least_contrast, 1.3 * 18);
  EXPECT_EQ(made.detector.reach, 0.6);
  EXPECT_EQ(made.speckle.levels, 18);
  EXPECT_EQ(made.speckle.noise, 0);
  const EchoLevels linear{.fluid = 6, .tissue = 100, .noise = 50, .known = true};
  EXPECT_EQ(effective_scene(scene, kHalfMmGeometry, {512, 512}, linear).speckle.noise, 0.5);
  EXPECT_EQ(effective_scene(scene, kHalfMmGeometry, {512, 512}, linear).speckle.levels, 0);
  EXPECT_EQ(effective_scene(scene, kHalfMmGeometry, {512, 512}, linear).detector.rise, 0.5);
  EXPECT_EQ(effective_scene(scene, kHalfMmGeometry, {512, 512}, linear).detector.reach, 0);
  const Scene unknown = effective_scene(scene, kHalfMmGeometry, {512, 512}, {});
  EXPECT_EQ(unknown.detector.threshold, Scene::Detector{}.threshold);
  EXPECT_EQ(unknown.detector.rise, 0.5);
  EXPECT_EQ(unknown.detector.least_tissue, 0);
  EXPECT_EQ(unknown.detector.least_contrast, 0);
  EXPECT_EQ(unknown.speckle.noise, Scene::Speckle{}.noise);
}

TEST(EffectiveSceneTest, AsksForMoreContrastThanSpeckleHas) {
  const auto least_contrast = [](SpeckleFilter filter, const EchoLevels& levels) {
    Scene scene;
    scene.speckle.filter = filter;
    return effective_scene(scene, kHalfMmGeometry, {512, 512}, levels).detector.least_contrast;
  };
  const EchoLevels log{.fluid = 10, .tissue = 110, .noise = 18, .known = true};
  EXPECT_EQ(least_contrast(SpeckleFilter::kNone, log), 1.3 * 18) << "slopes between two frames have little";
  EXPECT_EQ(least_contrast(SpeckleFilter::kMedian, log), 1.3 * 18);
  const EchoLevels flat{.fluid = 100, .tissue = 110, .noise = 18, .flat = true};
  EXPECT_EQ(least_contrast(SpeckleFilter::kGuided, flat), 1.6 * 18) << "what stands out of speckle alone";
  EXPECT_EQ(least_contrast(SpeckleFilter::kNone, flat), 3 * 18.0);
  const EchoLevels rings{.flat = true};
  EXPECT_EQ(least_contrast(SpeckleFilter::kGuided, rings), 255) << "nothing stands out of rings of air";
  EchoLevels linear{.fluid = 6, .tissue = 100, .noise = 50, .known = true};
  EXPECT_EQ(least_contrast(SpeckleFilter::kGuided, linear), 0) << "it would take tissue in shadows away";
  linear.known = false;
  linear.flat = true;
  EXPECT_EQ(least_contrast(SpeckleFilter::kGuided, linear), 1.6 * 50);
}

TEST(EffectiveSceneTest, AsksForMoreWhereAFilterLeavesTheSpeckle) {
  const EchoLevels flat{.fluid = 100, .tissue = 110, .noise = 18, .flat = true};
  const auto least_contrast = [&](auto&& change) {
    Scene scene;
    scene.speckle.noise = 0;
    change(scene);
    return effective_scene(scene, kHalfMmGeometry, {512, 512}, flat).detector.least_contrast;
  };
  EXPECT_EQ(least_contrast([](Scene&) {}), 1.6 * 18);
  EXPECT_EQ(least_contrast([](Scene& scene) { scene.speckle.levels = 1; }), 3 * 18.0);
  EXPECT_EQ(least_contrast([](Scene& scene) { scene.speckle.noise = 0.01; }), 3 * 18.0);
  EXPECT_EQ(least_contrast([](Scene& scene) { scene.speckle.size = 3; }), 3 * 18.0);
  EXPECT_EQ(least_contrast([](Scene& scene) { scene.detector.window = 4; }), 3 * 18.0);
}

TEST(EffectiveSceneTest, LeavesWhatTheUserHasSet) {
  Scene scene;
  scene.detector.threshold = 31;
  scene.detector.rise = 0.6;
  scene.detector.sheet_below = 12;
  scene.detector.least_tissue = 40;
  scene.detector.least_contrast = 9;
  scene.speckle.noise = 0;
  scene.speckle.levels = 7;
  const EchoLevels levels{.fluid = 10, .tissue = 110, .noise = 18, .known = true};
  const Scene made = effective_scene(scene, kHalfMmGeometry, {512, 512}, levels);
  scene.size = PictureSize{512, 512};
  EXPECT_EQ(first_pass_changed(scene, made), FirstPass::kNone);
}

TEST(EffectiveSceneTest, WindowsOfAFinerPictureCoverTheSameLength) {
  Scene scene;
  scene.camera.field_mm = 100;
  scene.filter.size = 9;
  scene.filter.islands = 7;
  scene.filter.holes = 5;
  scene.size = PictureSize{1024, 1024};
  const Scene made = effective_scene(scene, kHalfMmGeometry, {512, 512}, {});
  EXPECT_EQ(made.size, scene.size);
  EXPECT_EQ(made.filter.size, 17);
  EXPECT_EQ(made.filter.islands, 13);
  EXPECT_EQ(made.filter.holes, 9);
  scene.filter.size_mm =
      10;  // twice as much as the range of filter.size allows in a picture of the usual size
  EXPECT_EQ(effective_scene(scene, kHalfMmGeometry, {512, 512}, {}).filter.size, 61);
  scene.size = PictureSize{700, 700};
  EXPECT_EQ(effective_scene(scene, kHalfMmGeometry, {512, 512}, {}).filter.islands, 9);
}

}  // namespace
}  // namespace fanlight::test
