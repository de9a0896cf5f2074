// SPDX-License-Identifier: Apache-2.0
// Tests of the reference data of the accuracy table, without a renderer.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <span>

#include "tests/accuracy/depth_normals.hpp"
#include "tests/accuracy/face_features.hpp"
#include "tests/accuracy/flip.hpp"
#include "tests/accuracy/known_views.hpp"
#include "tests/accuracy/scanned_frames.hpp"
#include "tests/accuracy/test_fans.hpp"

namespace fanlight::test {
namespace {

constexpr std::array kProjections = {Projection::kParallel, Projection::kPerspective};

/// Depth at which the echo on a ray first rises to the middle between fluid and tissue; -1 if it never does.
double half_way_mm(const KnownSurface& surface, const PixelRay& ray, double from_mm, double to_mm) {
  constexpr double kStepMm = 0.005;
  const KnownEcho echo;
  const double half_way = (echo.fluid_grey + echo.tissue_grey) / 2;
  bool dark = false;
  for (double depth_mm = from_mm; depth_mm <= to_mm; depth_mm += kStepMm) {
    const bool bright = echo.grey(surface.below_mm(ray.at(depth_mm))) > half_way;
    if (dark && bright) return depth_mm;
    dark = !bright;
  }
  return -1;
}

TEST(KnownSurface, LiesWhereTheEchoRisesHalfWay) {
  const ScannedFan fan = test_fans().front().scanned();
  for (const TestSurface& tested : test_surfaces()) {
    for (const Projection projection : kProjections) {
      for (const KnownView& view : known_views(fan, *tested.surface, projection)) {
        for (std::uint32_t place = 5; place < view.size.height; place += 13) {
          const PixelRay ray = view.rays.ray(view.size.width - 1 - place, place);
          const auto entry_mm = tested.surface->entry_mm(ray, view.rays.first_mm(), view.rays.last_mm());
          const double marched_mm =
              half_way_mm(*tested.surface, ray, view.rays.first_mm(), view.rays.last_mm());
          EXPECT_NEAR(entry_mm.value_or(-1), marched_mm, 0.006) << tested.name;
        }
      }
    }
  }
}

TEST(DepthTruth, HoldsEverySurfaceInEveryFan) {
  for (const TestFan& fan : test_fans()) {
    for (const TestSurface& tested : test_surfaces()) {
      for (const KnownView& view : known_views(fan.scanned(), *tested.surface, Projection::kParallel)) {
        const auto judged = std::ranges::count(view.truth, Meets::kSurface, &PixelTruth::meets);
        EXPECT_GT(judged, view.size.width * view.size.height / 4) << tested.name << " in " << fan.name;
      }
    }
  }
}

TEST(DepthNormals, AreTheSurfaceOwnWhereDepthsAreTrue) {
  const ScannedFan fan = test_fans().front().scanned();
  for (const TestSurface& tested : test_surfaces()) {
    for (const Projection projection : kProjections) {
      for (const KnownView& view : known_views(fan, *tested.surface, projection)) {
        std::vector<float> depths_mm;
        for (const PixelTruth& truth : view.truth) {
          depths_mm.push_back(truth.meets == Meets::kSurface ? static_cast<float>(truth.depth_mm) : -1.0F);
        }
        const DepthNormals normals(depths_mm, view.size, view.rays, Normals::kCentral, 3);
        auto errors_deg =
            normal_errors_deg(normals, depths_mm, view.truth, view.rays, view.size, *tested.surface);
        std::ranges::sort(errors_deg);
        EXPECT_LT(errors_deg[errors_deg.size() / 2], 0.1) << tested.name;
      }
    }
  }
}

TEST(ScannedFrames, AreTheSameWithTheNormalOfEveryPlace) {
  auto fans = test_fans();
  TestFan& fan = fans.front();
  fan.angles_rad.resize(6);  // each volume takes seconds
  const Grains grains(fan, 3);
  const KnownRelief relief(kSurfaceDepthMm);
  const auto is_same = [](const Volume& one, const Volume& other) {
    for (std::uint32_t frame = 0; frame < one.stamp().frames; ++frame) {
      if (!std::ranges::equal(one.frame_pixels(frame), other.frame_pixels(frame))) return false;
    }
    return one.stamp().frames == other.stamp().frames;
  };
  for (const bool is_diffuse : {false, true}) {
    for (const double thickness_mm : {0.0, 1.0, 4.0}) {
      ScannerEcho echo = scanners().back().echo;  // the broad beam
      echo.is_diffuse = is_diffuse;
      echo.thickness_mm = thickness_mm;
      const Share share = [&](const glm::dvec3& at, const BeamAxes& axes, double depth_mm) {
        return echo.share(relief.below_mm(at), relief.normal(at), axes, depth_mm);
      };
      const Volume quick = scanned(fan, relief, echo, grains);
      const Volume whole = scanned(fan, share, echo, grains);
      EXPECT_TRUE(is_same(quick, whole)) << thickness_mm << " mm, diffuse " << is_diffuse;
    }
  }
}

/// Covariance of neighbours `apart` values away over the variance, mean 1 given.
double covariance(const SpeckleField& field, std::size_t values, std::size_t apart) {
  const float* const factors = field.frame(0);
  double sum = 0;
  for (std::size_t i = 0; i + apart < values; ++i) sum += (factors[i] - 1.0) * (factors[i + apart] - 1.0);
  return sum / static_cast<double>(values - apart);
}

TEST(SpeckleField, IsRayleighInGrainsOfTheGivenSize) {
  constexpr SpeckleField::Size kSize{.columns = 96, .rows = 96, .frames = 96};
  constexpr std::size_t kValues = std::size_t{96} * 96 * 96;
  const SpeckleField field(kSize, {.columns = 4, .rows = 2, .frames = 6}, 3);
  const std::span factors(field.frame(0), kValues);
  EXPECT_NEAR(std::accumulate(factors.begin(), factors.end(), 0.0) / kValues, 1, 0.001);
  const double variance = covariance(field, kValues, 0);
  EXPECT_NEAR(std::sqrt(variance), std::sqrt(4 / kPi - 1), 0.01);
  // Half a full width away the covariance is half the variance.
  EXPECT_NEAR(covariance(field, kValues, 2) / variance, 0.5, 0.06);
  EXPECT_NEAR(covariance(field, kValues, std::size_t{1} * kSize.columns) / variance, 0.5, 0.06);
  EXPECT_NEAR(covariance(field, kValues, std::size_t{3} * kSize.rows * kSize.columns) / variance, 0.5, 0.06);
}

TEST(SpeckleField, FollowsFromItsSeed) {
  constexpr SpeckleField::Size kSize{.columns = 8, .rows = 8, .frames = 8};
  constexpr SpeckleField::Grain kGrain{.columns = 2, .rows = 2, .frames = 2};
  const SpeckleField one(kSize, kGrain, 1);
  const SpeckleField same(kSize, kGrain, 1);
  const SpeckleField other(kSize, kGrain, 2);
  EXPECT_TRUE(std::equal(one.frame(0), one.frame(8), same.frame(0)));
  EXPECT_FALSE(std::equal(one.frame(0), one.frame(8), other.frame(0)));
}

TEST(FaceFeature, IsFoundWhereItIsWithItsHeight) {
  constexpr PictureSize kSize{.width = 80, .height = 60};
  constexpr double kPixelMm = 0.5;
  // A bump of 4 mm and a groove of 2 mm on a plane, narrower than the circle about them.
  std::vector<double> depth_mm;
  for (std::uint32_t row = 0; row < kSize.height; ++row) {
    for (std::uint32_t column = 0; column < kSize.width; ++column) {
      const double right_mm = (column - 39.5) * kPixelMm;
      const double up_mm = (29.5 - row) * kPixelMm;
      const double bump = std::exp(-std::pow(std::hypot(right_mm - 5.25, up_mm - 4.25), 2));
      const double groove = std::exp(-std::pow(std::hypot(right_mm + 6.25, up_mm + 3.25), 2));
      depth_mm.push_back(50 - 4 * bump + 2 * groove);
    }
  }
  const auto bump = found_feature({"bump", 4, 3, 4, 4}, depth_mm, kSize, kPixelMm);
  ASSERT_TRUE(bump);
  EXPECT_NEAR(bump->right_mm, 5.25, 1e-9);
  EXPECT_NEAR(bump->up_mm, 4.25, 1e-9);
  EXPECT_NEAR(bump->height_mm, 4, 0.01);
  const auto groove = found_feature({"groove", -5, -3, 4, 4, true}, depth_mm, kSize, kPixelMm);
  ASSERT_TRUE(groove);
  EXPECT_NEAR(groove->right_mm, -6.25, 1e-9);
  EXPECT_NEAR(groove->height_mm, 2, 0.01);
  EXPECT_FALSE(found_feature({"beside", 0, 0, 2, 100}, depth_mm, kSize, kPixelMm));
}

TEST(Flip, IsZeroForTheSamePictureAndGrowsWithTheDifference) {
  constexpr PictureSize kSize{.width = 48, .height = 40};
  const auto uniform = [](double grey) { return std::vector<glm::dvec3>(48 * 40, glm::dvec3(grey)); };
  const auto mean = [](const std::vector<double>& errors) {
    return std::accumulate(errors.begin(), errors.end(), 0.0) / static_cast<double>(errors.size());
  };
  const auto grey = uniform(0.5);
  EXPECT_NEAR(mean(flip_errors(grey, grey, kSize)), 0, 1e-3);
  const double slight = mean(flip_errors(grey, uniform(0.55), kSize));
  const double strong = mean(flip_errors(grey, uniform(0.8), kSize));
  EXPECT_GT(slight, 0.01);
  EXPECT_GT(strong, 2 * slight);
  EXPECT_LE(mean(flip_errors(uniform(0), uniform(1), kSize)), 1);
  // A line is a feature: it counts for more than as much of a difference spread over the picture.
  auto line = grey;
  for (std::size_t row = 0; row < kSize.height; ++row) line[row * kSize.width + 24] = glm::dvec3(1);
  const auto errors = flip_errors(grey, line, kSize);
  EXPECT_GT(errors[20 * kSize.width + 24], 5 * errors[20 * kSize.width + 4]);
}

}  // namespace
}  // namespace fanlight::test
