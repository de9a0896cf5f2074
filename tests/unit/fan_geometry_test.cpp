#include "proto/fan_geometry.hpp"

#include <gtest/gtest.h>

#include <limits>

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

// x lateral, y into the body, z = x cross y: a positive motor angle looks towards +z.
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
