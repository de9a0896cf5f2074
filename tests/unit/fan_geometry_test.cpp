// SPDX-License-Identifier: Apache-2.0
#include "proto/model/fan_geometry.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

namespace fanlight {
namespace {

FanGeometry reference() {
  FanGeometry geometry;
  geometry.columns = 512;
  geometry.rows = 512;
  geometry.pixel_width_mm = 0.3125;
  geometry.pixel_height_mm = 0.3125;
  geometry.face_column = 255.5;
  geometry.motor_radius_mm = 30;
  return geometry;
}

/// A curved array with lines on both sides of its axis.
FanGeometry convex() {
  FanGeometry geometry;
  geometry.kind = FrameKind::kConvexLines;
  geometry.columns = 129;
  geometry.rows = 400;
  geometry.pixel_height_mm = 0.25;
  geometry.face_column = 64;
  geometry.motor_radius_mm = 30;
  geometry.probe_radius_mm = 40;
  geometry.line_pitch_deg = 0.5;
  return geometry;
}

FanGeometry linear() {
  FanGeometry geometry = reference();
  geometry.kind = FrameKind::kLinearLines;
  geometry.columns = 128;
  geometry.pixel_width_mm = 0.5;
  geometry.face_column = 63.5;
  geometry.face_row = 4;
  return geometry;
}

TEST(FanGeometry, PointAndFanCoordinateAreInverse) {
  const FanGeometry geometry = reference();
  for (const double angle_deg : {-85.0, -35.0, 0.0, 1.5, 35.0, 85.0}) {
    for (const double depth_mm : {0.0, 1.0, 80.0, 159.7}) {
      const Point point = geometry.point(12, {.angle_rad = radians(angle_deg), .depth_mm = depth_mm});
      const FanCoordinate back = geometry.fan_coordinate(point.y_mm, point.z_mm);
      EXPECT_NEAR(degrees(back.angle_rad), angle_deg, 1e-9);
      EXPECT_NEAR(back.depth_mm, depth_mm, 1e-9);
      EXPECT_EQ(point.x_mm, 12);
    }
  }
}

TEST(FanGeometry, TheProbeFaceIsTheOriginAndStaysOnItsCircle) {
  const FanGeometry geometry = reference();
  const Point centre = geometry.point(0, {.angle_rad = 0, .depth_mm = 0});
  EXPECT_NEAR(centre.y_mm, 0, 1e-12);
  EXPECT_NEAR(centre.z_mm, 0, 1e-12);
  const Point tilted = geometry.point(0, {.angle_rad = radians(30), .depth_mm = 0});
  EXPECT_NEAR(tilted.y_mm, 30 * std::cos(radians(30)) - 30, 1e-12);
  EXPECT_NEAR(tilted.z_mm, 15, 1e-12);
}

// x lateral, y into the body, z = x cross y: a positive motor angle is towards +z.
TEST(FanGeometry, IsRightHanded) {
  const FanGeometry geometry = reference();
  const Point o = geometry.point(0, {.angle_rad = 0, .depth_mm = 50});
  const Point lateral = geometry.point(1, {.angle_rad = 0, .depth_mm = 50});
  const Point deeper = geometry.point(0, {.angle_rad = 0, .depth_mm = 51});
  const Point swept = geometry.point(0, {.angle_rad = radians(1), .depth_mm = 50});
  const double x[3] = {lateral.x_mm - o.x_mm, lateral.y_mm - o.y_mm, lateral.z_mm - o.z_mm};
  const double y[3] = {deeper.x_mm - o.x_mm, deeper.y_mm - o.y_mm, deeper.z_mm - o.z_mm};
  const double z[3] = {swept.x_mm - o.x_mm, swept.y_mm - o.y_mm, swept.z_mm - o.z_mm};
  const double triple = (x[1] * y[2] - x[2] * y[1]) * z[0] + (x[2] * y[0] - x[0] * y[2]) * z[1] +
                        (x[0] * y[1] - x[1] * y[0]) * z[2];
  EXPECT_GT(triple, 0);
}

TEST(FanGeometry, SpansItsPixelCentres) {
  const FanGeometry geometry = reference();
  EXPECT_DOUBLE_EQ(geometry.depth_mm(), 511 * 0.3125);
  EXPECT_DOUBLE_EQ(geometry.left_mm(), -geometry.right_mm());
  EXPECT_EQ(geometry.frame_bytes(), 512U * 512U);
}

TEST(FanGeometry, FramePlaceAndPlanePointAreInverse) {
  for (const FanGeometry& geometry : {reference(), convex(), linear()}) {
    ASSERT_TRUE(check(geometry));
    for (const double column : {0.0, 12.25, 63.5, 100.0, geometry.columns - 1.0, -3.0}) {
      for (const double row : {0.0, 17.5, geometry.rows - 1.0, geometry.rows + 9.0}) {
        const FramePlace back = geometry.frame_place(geometry.plane_point({column, row}));
        EXPECT_NEAR(back.column, column, 1e-9);
        EXPECT_NEAR(back.row, row, 1e-9);
      }
    }
  }
}

// Marked side, +x, larger column: equal for pixels and for both kinds of line. Rows ascend into the body.
TEST(FanGeometry, ColumnsGrowTowardsTheMarkedSideAndRowsIntoTheBody) {
  for (const FanGeometry& geometry : {reference(), convex(), linear()}) {
    for (const double column : {0.0, 30.0, geometry.columns - 2.0}) {
      for (const double row : {0.0, 200.0, geometry.rows - 2.0}) {
        const PlanePoint here = geometry.plane_point({column, row});
        EXPECT_GT(geometry.plane_point({column + 1, row}).x_mm, here.x_mm);
        EXPECT_GT(geometry.plane_point({column, row + 1}).depth_mm, here.depth_mm);
      }
    }
    EXPECT_NEAR(geometry.plane_point({geometry.face_column, geometry.face_row}).x_mm, 0, 1e-12);
    EXPECT_NEAR(geometry.plane_point({geometry.face_column, geometry.face_row}).depth_mm, 0, 1e-12);
  }
}

TEST(FanGeometry, ConvexLinesFanOutFromTheApex) {
  const FanGeometry geometry = convex();
  EXPECT_NEAR(degrees(geometry.line_angle_rad(128)), 32, 1e-12);
  // 30 deg to the marked side, 40 mm along the line: 80 mm from the apex.
  const PlanePoint at = geometry.plane_point({124, 160});
  EXPECT_NEAR(at.x_mm, 40, 1e-9);
  EXPECT_NEAR(at.depth_mm, 80 * std::cos(radians(30)) - 40, 1e-9);
  const FramePlace ahead = geometry.frame_place({.x_mm = 0, .depth_mm = 10});
  EXPECT_NEAR(ahead.column, 64, 1e-12);
  EXPECT_NEAR(ahead.row, 40, 1e-12);
  // No line passes above the array or behind its apex.
  EXPECT_LT(geometry.frame_place({.x_mm = 0, .depth_mm = -1}).row, 0);
  EXPECT_GT(geometry.frame_place({.x_mm = 1, .depth_mm = -60}).column, 128);
}

TEST(FanGeometry, LinearLinesLieAsCartesianPixelsDo) {
  FanGeometry pixels = linear();
  pixels.kind = FrameKind::kCartesian;
  const PlanePoint line = linear().plane_point({3, 40});
  const PlanePoint pixel = pixels.plane_point({3, 40});
  EXPECT_EQ(line.x_mm, pixel.x_mm);
  EXPECT_EQ(line.depth_mm, pixel.depth_mm);
  EXPECT_NEAR(line.depth_mm, 36 * 0.3125, 1e-12);
  EXPECT_DOUBLE_EQ(linear().nearest_mm(), -4 * 0.3125);
  EXPECT_DOUBLE_EQ(linear().right_mm(), 31.75);
}

TEST(FanGeometry, SamplesLieFartherApartWhereLinesAndFramesFanOut) {
  const FanGeometry flat{.pixel_width_mm = 0.4, .pixel_height_mm = 0.2, .motor_radius_mm = 40};
  EXPECT_DOUBLE_EQ(flat.sample_distances({7, 60, 0}, 0.001).x_mm, 0.4);
  EXPECT_DOUBLE_EQ(flat.sample_distances({7, 60, 0}, 0.001).y_mm, 0.2);
  EXPECT_DOUBLE_EQ(flat.sample_distances({7, 60, 0}, -0.01).z_mm, 1) << "100 mm from the axis";
  FanGeometry convex = flat;
  convex.kind = FrameKind::kConvexLines;
  convex.probe_radius_mm = 20;
  convex.line_pitch_deg = 1;
  EXPECT_DOUBLE_EQ(convex.sample_distances({30, 20, 0}, 0.001).x_mm, radians(1) * 50)
      << "50 mm from the apex";
  EXPECT_DOUBLE_EQ(convex.sample_distances({0, -20, 0}, 0).x_mm, 0) << "at the apex";
}

TEST(FanGeometry, BoundsOfConvexLinesHoldAllTheirSamples) {
  FanGeometry geometry = convex();
  const double reach_mm = 40 + 399 * 0.25;
  EXPECT_NEAR(geometry.right_mm(), reach_mm * std::sin(radians(32)), 1e-9);
  EXPECT_NEAR(geometry.left_mm(), -geometry.right_mm(), 1e-9);
  EXPECT_NEAR(geometry.depth_mm(), reach_mm - 40, 1e-9);
  EXPECT_NEAR(geometry.nearest_mm(), 40 * std::cos(radians(32)) - 40, 1e-9);
  EXPECT_LT(geometry.nearest_mm(), 0) << "the array bends away from its centre";

  for (const double face_column : {64.0, 32.3, -10.0, 150.0}) {
    geometry.face_column = face_column;
    ASSERT_TRUE(check(geometry)) << face_column;
    for (std::uint32_t column = 0; column < geometry.columns; ++column) {
      for (const std::uint32_t row : {0U, 200U, geometry.rows - 1}) {
        const PlanePoint at = geometry.plane_point({double{1} * column, double{1} * row});
        EXPECT_LE(at.x_mm, geometry.right_mm() + 1e-9);
        EXPECT_GE(at.x_mm, geometry.left_mm() - 1e-9);
        EXPECT_LE(at.depth_mm, geometry.depth_mm() + 1e-9);
        EXPECT_GE(at.depth_mm, geometry.nearest_mm() - 1e-9);
      }
    }
  }
}

// All lines are on one side of the axis: the line nearest to it reaches deepest and is the lateral bound.
TEST(FanGeometry, BoundsOfConvexLinesWithoutTheAxis) {
  FanGeometry geometry = convex();
  geometry.face_column = -10;
  const double reach_mm = 40 + 399 * 0.25;
  EXPECT_NEAR(geometry.depth_mm(), reach_mm * std::cos(radians(5)) - 40, 1e-9);
  EXPECT_NEAR(geometry.left_mm(), 40 * std::sin(radians(5)), 1e-9);
  EXPECT_NEAR(geometry.right_mm(), reach_mm * std::sin(radians(69)), 1e-9);
}

TEST(FanGeometry, TheFinestDistanceIsThatAlongConvexLines) {
  EXPECT_EQ(convex().finest_mm(), 0.25);
  EXPECT_EQ(linear().finest_mm(), 0.3125);
}

TEST(FanGeometry, RefusesConvexLinesThatAreNone) {
  ASSERT_TRUE(check(convex()));
  const auto refusal = [](auto change) {
    FanGeometry geometry = convex();
    change(geometry);
    const auto checked = check(geometry);
    return checked ? std::string("taken") : checked.error().message;
  };
  EXPECT_EQ(refusal([](FanGeometry& g) { g.line_pitch_deg = 0; }),
            "the fan geometry's line_pitch_deg is 0, expected 0.001 to 10");
  EXPECT_EQ(refusal([](FanGeometry& g) { g.line_pitch_deg = 10.5; }),
            "the fan geometry's line_pitch_deg is 10.5, expected 0.001 to 10");
  EXPECT_EQ(refusal([](FanGeometry& g) { g.line_pitch_deg = std::nan(""); }),
            "the fan geometry's line_pitch_deg is nan, expected 0.001 to 10");
  EXPECT_EQ(refusal([](FanGeometry& g) { g.probe_radius_mm = -1; }),
            "the fan geometry's probe_radius_mm is -1, expected 0 to 1000");
  EXPECT_EQ(refusal([](FanGeometry& g) { g.line_pitch_deg = 1.5; }),
            "the outermost scan line stands at 96 deg, expected at most 89");
  EXPECT_EQ(refusal([](FanGeometry& g) { g.face_column = -60; }),
            "the outermost scan line stands at 94 deg, expected at most 89");
  EXPECT_EQ(refusal([](FanGeometry& g) { g.face_column = 200; }),
            "the outermost scan line stands at 100 deg, expected at most 89");
  EXPECT_EQ(refusal([](FanGeometry& g) { g.face_row = 164; }),
            "the first sample lies -1 mm from the apex of the scan lines, expected 0 or more");
  EXPECT_EQ(refusal([](FanGeometry& g) { g.pixel_width_mm = 0; }), "taken") << "it is not read";

  FanGeometry phased = convex();  // all lines begin at one point
  phased.probe_radius_mm = 0;
  EXPECT_TRUE(check(phased));
  FanGeometry parallel = linear();
  parallel.line_pitch_deg = 50;
  EXPECT_TRUE(check(parallel)) << "it is not read";
  parallel.pixel_width_mm = 0;
  EXPECT_FALSE(check(parallel));
}

TEST(FanGeometry, RefusesEachFieldOutOfItsRange) {
  EXPECT_TRUE(check(reference()));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [](auto change) {
    FanGeometry geometry = reference();
    change(geometry);
    return !check(geometry);
  };
  EXPECT_TRUE(refused([](FanGeometry& g) { g.columns = 1; }));
  EXPECT_TRUE(refused([](FanGeometry& g) { g.rows = 4097; }));
  EXPECT_TRUE(refused([](FanGeometry& g) { g.pixel_width_mm = 0; }));
  EXPECT_TRUE(refused([nan](FanGeometry& g) { g.pixel_height_mm = nan; }));
  EXPECT_TRUE(refused([](FanGeometry& g) { g.motor_radius_mm = 0; }));
  EXPECT_TRUE(refused([nan](FanGeometry& g) { g.face_column = nan; }));
  EXPECT_TRUE(refused([](FanGeometry& g) { g.face_row = 511; }));
}

}  // namespace
}  // namespace fanlight
