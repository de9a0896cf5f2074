// SPDX-License-Identifier: Apache-2.0
// The simulated probe's scenes of bodies: their surfaces, and the frames that show them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>
#include <tuple>
#include <utility>

#include "tests/unit/phantom_frames.hpp"

namespace fanlight::test {
namespace {

using Scene = PhantomSource::Scene;

/// Without what blurs the surface in a frame.
PhantomSource::Config sharp(Scene scene, FrameKind scan) {
  return {.scan = scan,
          .columns = scan == FrameKind::kCartesian ? 512U : 192U,
          .rows = 512,
          .beam_mm = 0,
          .speckle = PhantomSource::Speckle::kOff,
          .clutter = PhantomSource::Clutter::kOff,
          .scene = scene,
          .motion = PhantomScene::Motion::kStill,
          .pace = PhantomSource::Pace::kUnpaced};
}

float ball_mm(const glm::vec3& at) {
  return glm::length(at) - 10;
}

float half_space_mm(const glm::vec3& at) {
  return at.z;
}

TEST(DistanceGridTest, HasTheSurfaceWhereTheShapeHasIt) {
  const DistanceGrid grid(ball_mm, glm::vec3(-20), glm::vec3(20), 0.5F);
  for (int i = 0; i < 200; ++i) {
    const auto angle = static_cast<float>(i);
    const glm::vec3 towards =
        glm::normalize(glm::vec3(std::cos(angle), std::sin(angle), std::cos(2.7F * angle)));
    EXPECT_NEAR(grid.at(10.0F * towards), 0, 0.02);
    EXPECT_NEAR(grid.at(11.0F * towards), 1, 0.02);
    EXPECT_NEAR(grid.at(8.0F * towards), -2, 0.02);
    EXPECT_NEAR(grid.at(17.0F * towards), 7, 0.2) << "where only every fourth node was sampled";
  }
}

TEST(DistanceGridTest, NeverTellsMoreThanTheDistanceOutsideItsBox) {
  const DistanceGrid grid(ball_mm, glm::vec3(-12), glm::vec3(12), 0.5F);
  for (float x = 12.5F; x < 100; x += 3.3F) {
    EXPECT_LE(grid.at({x, 0, 0}), x - 10);
    EXPECT_LE(grid.at({x, x, 5}), ball_mm({x, x, 5}));
    EXPECT_GT(grid.at({x, x, 5}), 0);
  }
}

TEST(DistanceGridTest, GoesOnInsideABodyThatLeavesItsBox) {
  const DistanceGrid grid(half_space_mm, glm::vec3(-4), glm::vec3(4), 0.5F);
  EXPECT_LT(grid.at({3, 3, -50}), 0);
}

/// The distance of a pixel from the surface.
double distance_mm(const PhantomSource& source, const FrameStamp& stamp, double column, double row) {
  const FanGeometry& geometry = source.description().geometry;
  const PlanePoint at = geometry.plane_point({column, row});
  const Point point = geometry.point(at.x_mm, {.angle_rad = stamp.angle_rad, .depth_mm = at.depth_mm});
  const BodyScene::Poses poses = source.bodies()->poses_at(source.scene_time_s(stamp));
  return source.bodies()->distance_mm(poses, {point.x_mm, point.y_mm, point.z_mm});
}

/// The row at which a column or scan line meets the surface, from a fine search of the scene.
std::optional<double> true_row(const PhantomSource& source, const FrameStamp& stamp, double column) {
  const std::uint32_t rows = source.description().geometry.rows;
  for (double row = 0; row < rows - 1; row += 0.02) {
    const double away_mm = distance_mm(source, stamp, column, row);
    if (away_mm <= 0) return row;
    row += 0.5 * away_mm;  // safe: a row is 0.3 mm
  }
  return std::nullopt;
}

/// The row of the first rise to the grey level of tissue, between pixels.
std::optional<double> seen_row(const FanGeometry& geometry, const Frame& frame, std::uint32_t column) {
  constexpr double kMiddle = 110;  // fluid is dark, skin almost white
  const auto grey = [&](std::uint32_t row) {
    return static_cast<double>(frame.pixels[row * geometry.columns + column]);
  };
  for (std::uint32_t row = 1; row < geometry.rows; ++row) {
    if (grey(row) < kMiddle) continue;
    return row - 1 + (kMiddle - grey(row - 1)) / (grey(row) - grey(row - 1));
  }
  return std::nullopt;
}

class BodyScan : public testing::TestWithParam<std::tuple<Scene, FrameKind>> {};

TEST_P(BodyScan, StepsUpWhereTheTrueSurfaceIs) {
  const auto [scene, scan] = GetParam();
  const auto source = make(sharp(scene, scan));
  ASSERT_NE(source, nullptr);
  const FanGeometry& geometry = source->description().geometry;
  const double to_next_line = scan == FrameKind::kCartesian ? 4 : 1;  // columns, at the depth of the bodies
  int compared = 0;
  int found = 0;
  for (int i = 0; i < 35; ++i) {
    const Frame frame = next(*source);
    if (i % 4 != 1) continue;
    const std::uint32_t step = geometry.columns / 21;
    for (std::uint32_t column = 2 * step; column < 20 * step; column += step) {
      const auto truth = true_row(*source, frame.stamp, column);
      const auto left = true_row(*source, frame.stamp, column - to_next_line);
      const auto right = true_row(*source, frame.stamp, column + to_next_line);
      if (!truth || !left || !right || std::abs(*left - *right) > 8) continue;
      const auto seen = seen_row(geometry, frame, column);
      ++compared;
      if (!seen) continue;  // in a shadow
      ++found;
      // The step is half a millimetre thick, and the beam's blur across the lines brings a slanted surface
      // forward, up to where its neighbours meet it.
      EXPECT_LE(*seen, *truth + 1) << "column " << column << " of frame " << i;
      const double nearest_row = std::min({*truth, *left, *right}) - 3;
      EXPECT_TRUE(*seen >= nearest_row || distance_mm(*source, frame.stamp, column, *seen) < 0.5)
          << "column " << column << " of frame " << i << ", row " << *seen << " of " << *truth;
    }
  }
  EXPECT_GT(compared, 30);
  EXPECT_GE(found, 0.97 * compared);
}

INSTANTIATE_TEST_SUITE_P(OfEachKind, BodyScan,
                         testing::Combine(testing::Values(Scene::kFace, Scene::kSphere, Scene::kPlane),
                                          testing::Values(FrameKind::kCartesian, FrameKind::kConvexLines,
                                                          FrameKind::kLinearLines)));

TEST(BodyFrames, ScanTheSphereWhereItIsSaidToBe) {
  const auto source = make(sharp(Scene::kSphere, FrameKind::kConvexLines));
  ASSERT_NE(source, nullptr);
  const BodyScene::Poses poses = source->bodies()->poses_at(0);
  for (const float angle : {0.0F, 0.4F, 1.3F, 2.9F}) {
    const glm::vec3 towards(std::sin(angle), -std::cos(angle), 0);
    EXPECT_NEAR(source->bodies()->distance_mm(poses, glm::vec3(0, 90, 0) + 30.0F * towards), 0, 0.02);
  }
}

/// Rows over which a column rises from dark to bright.
int rise_rows(const Frame& frame, const FanGeometry& geometry, std::uint32_t column) {
  int rows = 0;
  for (std::uint32_t row = 0; row < geometry.rows; ++row) {
    const int grey = frame.pixels[row * geometry.columns + column];
    if (grey > 60 && grey < 170) ++rows;
    if (grey >= 170) break;
  }
  return rows;
}

TEST(BodyFrames, AreBlurredByAThickBeamWhereTheSurfaceIsSlantedAcrossTheFrame) {
  auto config = sharp(Scene::kPlane, FrameKind::kLinearLines);
  const auto thin = make(config);
  config.beam_mm = 8;
  const auto thick = make(config);
  const FanGeometry& geometry = thin->description().geometry;
  // The plane is tilted in elevation: it faces a frame of one side, and is slanted to the other side's.
  int thin_rows = 0;
  int thick_rows = 0;
  for (int i = 0; i < 35; ++i) {
    thin_rows += rise_rows(next(*thin), geometry, 96);
    thick_rows += rise_rows(next(*thick), geometry, 96);
  }
  EXPECT_GT(thick_rows, 2 * thin_rows);
}

TEST(BodyFrames, AreDrawnInTheSmallestAndLargestSizes) {
  for (const FrameKind scan : {FrameKind::kCartesian, FrameKind::kConvexLines, FrameKind::kLinearLines}) {
    for (const std::uint32_t side : {16U, 1500U}) {
      auto config = sharp(Scene::kSphere, scan);
      config.columns = side;
      config.rows = side;
      config.beam_mm = 8;
      config.clutter = PhantomSource::Clutter::kOn;
      config.frames_per_volume = 2;
      config.sweep_deg = 170;
      const auto source = make(config);
      ASSERT_NE(source, nullptr);
      const Frame frame = next(*source);
      EXPECT_EQ(frame.pixels.size(), std::size_t{side} * side);
    }
  }
}

TEST(BodyFrames, AreDarkBehindBone) {
  const auto source = make(sharp(Scene::kFace, FrameKind::kConvexLines));
  ASSERT_NE(source, nullptr);
  const FanGeometry& geometry = source->description().geometry;
  for (int i = 0; i < 17; ++i) next_stamp(*source);
  const Frame middle = next(*source);
  const auto row = true_row(*source, middle.stamp, 96);
  ASSERT_TRUE(row);
  const auto mean_grey = [&](double from_mm, double to_mm) {
    double sum = 0;
    int count = 0;
    for (double mm = from_mm; mm < to_mm; mm += geometry.pixel_height_mm) {
      const auto at = static_cast<std::uint32_t>(*row + mm / geometry.pixel_height_mm);
      sum += middle.pixels[at * geometry.columns + 96];
      ++count;
    }
    return sum / count;
  };
  const double skin = mean_grey(0.5, 2);
  const double behind = mean_grey(12, 20);
  EXPECT_GT(skin, 160);
  EXPECT_LT(behind, skin - 60);
  EXPECT_GT(mean_grey(-20, -5), 0) << "fluid is not black";
}

/// Mean grey level of some rows and columns.
double mean_grey(const Frame& frame, std::uint32_t columns, std::pair<std::uint32_t, std::uint32_t> rows,
                 std::pair<std::uint32_t, std::uint32_t> across) {
  double sum = 0;
  for (std::uint32_t row = rows.first; row < rows.second; ++row)
    for (std::uint32_t column = across.first; column < across.second; ++column)
      sum += frame.pixels[row * columns + column];
  return sum / ((rows.second - rows.first) * (across.second - across.first));
}

TEST(BodyFrames, HaveReverberationBelowTheProbeAndSideLobesBesideABody) {
  auto config = sharp(Scene::kSphere, FrameKind::kConvexLines);
  const auto clean_source = make(config);
  config.clutter = PhantomSource::Clutter::kOn;
  const auto source = make(config);
  for (int i = 0; i < 17; ++i) {
    next_stamp(*clean_source);
    next_stamp(*source);
  }
  const Frame clean = next(*clean_source);
  const Frame frame = next(*source);
  const auto added = [&](std::pair<std::uint32_t, std::uint32_t> rows,
                         std::pair<std::uint32_t, std::uint32_t> across) {
    return mean_grey(frame, config.columns, rows, across) - mean_grey(clean, config.columns, rows, across);
  };
  // A row is 0.31 mm, and 60 dB are 255 grey levels. Fluid is 34 dB below tissue.
  EXPECT_NEAR(added({0, 8}, {0, 192}), (34 - 5) * 255 / 60.0, 15) << "below the face";
  EXPECT_LT(added({72, 80}, {0, 192}), 1) << "23 mm below it";
  // The sphere's near side at the range of 70 mm meets lines 96 +- 34, and the lobes 31 lines beside them.
  EXPECT_GT(added({215, 225}, {40, 50}), 5) << "beside the sphere";
  EXPECT_LT(added({215, 225}, {0, 10}), 2) << "further from it";
  EXPECT_NEAR(added({215, 225}, {90, 100}), 0, 1) << "within it";
}

TEST(BodyFrames, MoveUnlessTheyAreStill) {
  const BodyScene moving(BodyScene::Kind::kFace, true);
  const BodyScene still(BodyScene::Kind::kFace, false);
  const auto nose = [](const BodyScene& scene, double time_s) {
    return scene.distance_mm(scene.poses_at(time_s), {0, 50, 0});
  };
  EXPECT_EQ(nose(still, 0), nose(still, 1.3));
  EXPECT_NE(nose(moving, 0), nose(moving, 1.3));
  EXPECT_NEAR(nose(moving, 0), nose(moving, 1.3), 6);
}

TEST(BodyFrames, AreTheSameForTheSameSeed) {
  auto config = sharp(Scene::kFace, FrameKind::kCartesian);
  config.speckle = PhantomSource::Speckle::kOn;
  const auto first = make(config);
  const auto second = make(config);
  config.seed = 2;
  const auto other = make(config);
  const Frame frame = next(*first);
  EXPECT_EQ(frame.pixels, next(*second).pixels);
  EXPECT_NE(frame.pixels, next(*other).pixels);
}

}  // namespace
}  // namespace fanlight::test
