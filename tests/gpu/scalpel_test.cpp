// SPDX-License-Identifier: Apache-2.0
// What is cut away is not shown, and what lies behind it is.
#include <fmt/format.h>

#include <string>

#include "tests/support/gpu_rig.hpp"
#include "tests/support/made_volume.hpp"

namespace fanlight::test::scalpel_tests {
namespace {

constexpr FanGeometry kLayers{.columns = 96,
                              .rows = 200,
                              .pixel_width_mm = 1,
                              .pixel_height_mm = 0.5,
                              .face_column = 47.5,
                              .face_row = 0,
                              .motor_radius_mm = 30};
constexpr PictureSize kSize{.width = 48, .height = 48};
constexpr double kPlacentaMm = 30;
constexpr double kFaceMm = 60;

std::vector<double> layer_angles() {
  std::vector<double> angles_rad;
  for (int frame = 0; frame < 9; ++frame) angles_rad.push_back(radians(5.0 * (frame - 4)));
  return angles_rad;
}

/// Fluid, a bright layer of 10 mm, fluid, and less bright tissue.
double level_at(const Point& at) {
  if (at.y_mm >= kFaceMm) return 120;
  return at.y_mm >= kPlacentaMm && at.y_mm < kPlacentaMm + 10 ? 200 : 5;
}

/// A square of 16 mm, cut into a picture that is seen from the probe.
std::string square(const char* kind, double nearest_mm, double farthest_mm) {
  return fmt::format("{} {} {} from 0 0 0 right 1 0 0 up 0 0 1 eye 0 outline -8 -8 8 -8 8 8 -8 8", kind,
                     nearest_mm, farthest_mm);
}

class ScalpelTest : public GpuTest {
 protected:
  ScalpelTest() {
    scene_.camera.target = {.x_mm = 0, .y_mm = 50, .z_mm = 0};
    scene_.camera.distance_mm = 50;
    scene_.camera.field_mm = 32;
    scene_.speckle.filter = SpeckleFilter::kNone;
    scene_.detector.threshold = 20;
    scene_.detector.least_tissue = 1;
    scene_.filter.size_mm = 0;
    scene_.filter.size = 1;
    scene_.filter.holes = scene_.filter.islands = 1;
    if (!renderer_->load(volume_)) throw std::runtime_error("the volume was refused");
  }

  Picture shown(const std::string& cuts, Mode mode = Mode::kSurface) {
    scene_.cuts.shapes = *CutList::parse(cuts);
    scene_.mode = mode;
    renderer_->show({.revision = ++revision_, .scene = scene_});
    return next_picture(*renderer_);
  }
  /// The depth below the probe at a distance right of the picture's middle; negative without a surface.
  double depth_mm(double right_mm) {
    const auto column = static_cast<std::size_t>(24 + right_mm * 48 / 32);
    return renderer_->read_depth()->cast_mm[std::size_t{24} * kSize.width + column];
  }

  Scene scene_ = scene_for(kLayers, layer_angles().front(), layer_angles().back());
  RenderCounters counters_;
  std::unique_ptr<Renderer> renderer_ = made_renderer(kLayers, layer_angles(), kSize, scene_, counters_);
  const Volume volume_ = made_volume(kLayers, layer_angles(), level_at);
  std::uint64_t revision_ = 1;
};

TEST_F(ScalpelTest, ShowsWhatLiesBehindACutToADepth) {
  const Picture whole = shown("");
  EXPECT_NEAR(depth_mm(0), kPlacentaMm, 0.5);
  shown(square("inside", -3000, 50));
  EXPECT_NEAR(depth_mm(0), kFaceMm, 0.5);
  EXPECT_NEAR(depth_mm(6), kFaceMm, 0.5);
  EXPECT_NEAR(depth_mm(10), kPlacentaMm, 0.5);
  shown(square("outside", -3000, 50));
  EXPECT_NEAR(depth_mm(0), kPlacentaMm, 0.5);
  EXPECT_NEAR(depth_mm(10), kFaceMm, 0.5);
  // Restored.
  EXPECT_EQ(shown("").rgba, whole.rgba);
}

TEST_F(ScalpelTest, LeavesNothingBehindACutOfFullDepth) {
  shown(square("inside", -3000, 3000));
  EXPECT_LT(depth_mm(0), 0);
  EXPECT_NEAR(depth_mm(10), kPlacentaMm, 0.5);
}

TEST_F(ScalpelTest, AddsCutsAndTakesThemBack) {
  const std::string first = square("inside", -3000, 50);
  shown(first + "; balls 6 at 12 30 0");
  EXPECT_NEAR(depth_mm(0), kFaceMm, 0.5);
  EXPECT_NEAR(depth_mm(12), kFaceMm, 0.5);
  shown(first);
  EXPECT_NEAR(depth_mm(0), kFaceMm, 0.5);
  EXPECT_NEAR(depth_mm(12), kPlacentaMm, 0.5);
}

TEST_F(ScalpelTest, HoldsForTheNextVolume) {
  shown(square("inside", -3000, 50));
  ASSERT_TRUE(renderer_->load(made_volume(kLayers, layer_angles(), [](const Point& at) {
    return level_at({.x_mm = at.x_mm, .y_mm = at.y_mm - 2, .z_mm = at.z_mm});
  })));
  next_picture(*renderer_);
  EXPECT_NEAR(depth_mm(0), kFaceMm + 2, 0.5);
  EXPECT_NEAR(depth_mm(10), kPlacentaMm + 2, 0.5);
}

TEST_F(ScalpelTest, LeavesTheEchoOfWhatIsCutOutOfOtherModes) {
  const auto grey = [this](const std::string& cuts, Mode mode) {
    const Picture picture = shown(cuts, mode);
    return picture.rgba[4 * (std::size_t{24} * kSize.width + 24)];
  };
  const std::string cut = square("inside", -3000, 50);
  EXPECT_NEAR(grey("", Mode::kMaximum), 200, 3);
  EXPECT_NEAR(grey(cut, Mode::kMaximum), 120, 3);
  EXPECT_GT(grey("", Mode::kVolume), grey(cut, Mode::kVolume) + 20);
  EXPECT_NE(grey("", Mode::kMean), grey(cut, Mode::kMean));
}

TEST_F(ScalpelTest, IsSeenInThePlanes) {
  // The first plane is that of x and depth: the placenta lies 20 mm above its middle.
  const auto at = [](const Picture& picture, std::size_t column) {
    const std::uint8_t* const pixel = &picture.rgba[4 * (std::size_t{2} * kSize.width + column)];
    return std::array<int, 3>{pixel[0], pixel[1], pixel[2]};
  };
  scene_.camera.field_mm = 40;
  const auto whole = at(shown("", Mode::kSlices), 12);
  const auto cut = at(shown(square("inside", -3000, 50), Mode::kSlices), 12);
  EXPECT_NEAR(whole[0], 200, 10);
  EXPECT_NEAR(cut[0], 60, 10);
  EXPECT_EQ(cut[0], cut[2]);
}

}  // namespace
}  // namespace fanlight::test::scalpel_tests
