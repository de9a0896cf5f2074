// SPDX-License-Identifier: Apache-2.0
// A thin bright sheet in fluid is placed at its front, and a thick layer is no sheet.
#include <cmath>

#include "tests/support/gpu_rig.hpp"
#include "tests/support/made_volume.hpp"

namespace fanlight::test::sheet_tests {
namespace {

constexpr FanGeometry kFine{.columns = 48,
                            .rows = 320,
                            .pixel_width_mm = 1,
                            .pixel_height_mm = 0.25,
                            .face_column = 23.5,
                            .face_row = 0,
                            .motor_radius_mm = 30};
constexpr PictureSize kSide{.width = 32, .height = 32};
constexpr double kSheetMm = 50;
constexpr double kDeviationMm = 0.6;
constexpr double kFluid = 10;
constexpr double kPeak = 160;

double sheet(const Point& at) {
  const double away = (at.y_mm - kSheetMm) / kDeviationMm;
  return kFluid + (kPeak - kFluid) * std::exp(-0.5 * away * away);
}

double thick_layer(const Point& at) {
  return at.y_mm >= kSheetMm && at.y_mm < kSheetMm + 15 ? kPeak : kFluid;
}

class SheetTest : public GpuTest {
 protected:
  /// The depth below the probe of the surface in the middle of the picture.
  template <typename Grey>
  static double found_mm(Grey grey, double sheet_below) {
    const std::vector<double> angles_rad = {-0.2, -0.15, -0.1, -0.05, 0, 0.05, 0.1, 0.15, 0.2};
    Scene scene = scene_for(kFine, angles_rad.front(), angles_rad.back());
    scene.camera.target = {.x_mm = 0, .y_mm = kSheetMm, .z_mm = 0};
    scene.camera.distance_mm = kSheetMm;
    scene.camera.field_mm = 20;
    scene.rays.step_mm = 0.25;
    scene.speckle.filter = SpeckleFilter::kNone;
    scene.detector = {.threshold = 10,
                      .window = 24,
                      .place = SurfacePlace::kLevel,
                      .rise = 0.5,
                      .sheet_below = sheet_below,
                      .least_tissue = 30};
    RenderCounters counters;
    const auto renderer = made_renderer(kFine, angles_rad, kSide, scene, counters);
    if (auto loaded = renderer->load(made_volume(kFine, angles_rad, grey)); !loaded)
      throw std::runtime_error(loaded.error().message);
    next_picture(*renderer);
    return renderer->read_depth()->cast_mm[kSide.width * kSide.height / 2 + kSide.width / 2];
  }

  /// Where the sheet's echo comes to this level.
  static double rises_to_mm(double level) {
    return kSheetMm - kDeviationMm * std::sqrt(2 * std::log((kPeak - kFluid) / (level - kFluid)));
  }
};

TEST_F(SheetTest, LiesBelowItsPeakByTheField) {
  // The peak is the mean of two samples, half a millimetre apart, and lower by up to 15 grey levels.
  for (const double below : {30.0, 60.0}) {
    EXPECT_GT(found_mm(sheet, below), rises_to_mm(kPeak - below - 15) - 0.1) << below;
    EXPECT_LT(found_mm(sheet, below), rises_to_mm(kPeak - below) + 0.1) << below;
  }
  EXPECT_LT(found_mm(sheet, 60), found_mm(sheet, 30) - 0.1);
}

TEST_F(SheetTest, HasItsLowestLevelHalfway) {
  EXPECT_NEAR(found_mm(sheet, 255), found_mm(sheet, 120), 1e-4);
}

TEST_F(SheetTest, IsNoThickLayer) {
  EXPECT_NEAR(found_mm(thick_layer, 1), kSheetMm, 0.3);
  EXPECT_NEAR(found_mm(thick_layer, 1), found_mm(thick_layer, 200), 1e-4);
}

}  // namespace
}  // namespace fanlight::test::sheet_tests
