// SPDX-License-Identifier: Apache-2.0
// A surface as glass shows the outlines of what lies inside, where they are.
#include <cmath>

#include "tests/support/gpu_rig.hpp"
#include "tests/support/made_volume.hpp"

namespace fanlight::test::glass_tests {
namespace {

constexpr FanGeometry kFan{.columns = 96,
                           .rows = 200,
                           .pixel_width_mm = 1,
                           .pixel_height_mm = 0.5,
                           .face_column = 47.5,
                           .face_row = 0,
                           .motor_radius_mm = 30};
constexpr PictureSize kSize{.width = 64, .height = 64};
constexpr double kDepthMm = 60;
constexpr double kHeadMm = 26;
constexpr double kCystMm = 12;
constexpr const char* kCystCutAway = "balls 16 at 0 60 0";

std::vector<double> fan_angles() {
  std::vector<double> angles_rad;
  angles_rad.reserve(61);
  for (int frame = 0; frame < 61; ++frame) angles_rad.push_back(radians(frame - 30.0));
  return angles_rad;
}

/// A ball of tissue in fluid, with a ball of fluid in its middle.
double level_at(const Point& at) {
  const double from_middle_mm = std::hypot(at.x_mm, at.y_mm - kDepthMm, at.z_mm);
  return from_middle_mm < kHeadMm && from_middle_mm > kCystMm ? 120 : 5;
}

class GlassTest : public GpuTest {
 protected:
  GlassTest() {
    scene_.camera.target = {.x_mm = 0, .y_mm = kDepthMm, .z_mm = 0};
    scene_.camera.distance_mm = kDepthMm;
    scene_.camera.field_mm = 64;
    scene_.light.kind = LightKind::kDirectional;
    scene_.light.right_mm = scene_.light.up_mm = 0;
    scene_.light.depth_mm = -100;
    if (!renderer_->load(made_volume(kFan, fan_angles(), level_at)))
      throw std::runtime_error("the volume was refused");
  }

  Picture shown(double amount) {
    scene_.glass.amount = amount;
    renderer_->show({.revision = ++revision_, .scene = scene_});
    return next_picture(*renderer_);
  }

  Scene scene_ = scene_for(kFan, fan_angles().front(), fan_angles().back());
  RenderCounters counters_;
  std::unique_ptr<Renderer> renderer_ = made_renderer(kFan, fan_angles(), kSize, scene_, counters_);
  std::uint64_t revision_ = 1;
};

/// The mean of the light, linear, between two distances from the picture's middle, in mm: of green, 0 to 1.
double mean_light(const Picture& picture, double least_mm, double most_mm) {
  double sum = 0;
  int count = 0;
  for (std::uint32_t row = 0; row < kSize.height; ++row) {
    for (std::uint32_t column = 0; column < kSize.width; ++column) {
      const double from_middle_mm = std::hypot(column - 31.5, row - 31.5);
      if (from_middle_mm < least_mm || from_middle_mm > most_mm) continue;
      const double shown = picture.rgba[4 * (std::size_t{row} * kSize.width + column) + 1] / 255.0;
      sum += std::pow(shown, 2.2);
      ++count;
    }
  }
  return sum / count;
}

TEST_F(GlassTest, ShowsTheOutlinesOfWhatLiesInside) {
  const Picture glass = shown(1);
  const double inner_outline = mean_light(glass, kCystMm - 1.5, kCystMm);
  EXPECT_GT(inner_outline, 2 * mean_light(glass, 0, kCystMm / 2));
  EXPECT_GT(inner_outline, 3 * mean_light(glass, kCystMm + 3, kHeadMm - 8));
  EXPECT_GT(mean_light(glass, kHeadMm - 2, kHeadMm - 0.5), 2 * mean_light(glass, kCystMm + 3, kHeadMm - 8));

  const Picture skin = shown(0);
  EXPECT_LT(mean_light(skin, kCystMm - 1.5, kCystMm), mean_light(skin, 0, kCystMm / 2));
}

TEST_F(GlassTest, BecomesClearByDegrees) {
  const double skin = mean_light(shown(0), 0, kCystMm / 2);
  const double half = mean_light(shown(0.5), 0, kCystMm / 2);
  const double glass = mean_light(shown(1), 0, kCystMm / 2);
  EXPECT_GT(skin, 1.1 * half);
  EXPECT_GT(half, 1.1 * glass);
}

TEST_F(GlassTest, MovesNoSurface) {
  shown(0);
  const auto skin_mm = renderer_->read_depth()->cast_mm;
  shown(1);
  EXPECT_EQ(renderer_->read_depth()->cast_mm, skin_mm);
}

TEST_F(GlassTest, ShowsNoOutlineOfWhatIsCutAway) {
  scene_.cuts.shapes = *CutList::parse(kCystCutAway);
  const Picture cut = shown(1);
  EXPECT_LT(mean_light(cut, kCystMm - 1.5, kCystMm), 1.5 * mean_light(cut, kCystMm + 3, kHeadMm - 8));
}

TEST_F(GlassTest, SaysThatDepthsAloneDoNotMakeThePicture) {
  EXPECT_TRUE(shown(0.5).stamp.view.part.seen_through);
  EXPECT_FALSE(shown(0).stamp.view.part.seen_through);
}

}  // namespace
}  // namespace fanlight::test::glass_tests
