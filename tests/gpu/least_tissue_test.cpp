// SPDX-License-Identifier: Apache-2.0
// A faint layer before bright tissue: a surface, or passed over by the rays.
#include <algorithm>
#include <cmath>

#include "tests/support/gpu_rig.hpp"
#include "tests/support/made_volume.hpp"

namespace fanlight::test::least_tissue_tests {
namespace {

constexpr FanGeometry kLayers{.columns = 48,
                              .rows = 200,
                              .pixel_width_mm = 1,
                              .pixel_height_mm = 0.5,
                              .face_column = 23.5,
                              .face_row = 0,
                              .motor_radius_mm = 30};
constexpr PictureSize kSide{.width = 32, .height = 32};
constexpr double kFaintMm = 30;
constexpr double kTissueMm = 60;

std::vector<double> layer_angles() {
  std::vector<double> angles_rad;
  for (int frame = 0; frame < 9; ++frame) angles_rad.push_back(radians(3.0 * (frame - 4)));
  return angles_rad;
}

/// Fluid of level 10, a layer of 50 that is 12 mm thick, fluid, tissue of 140.
double level_at(const Point& at) {
  if (at.y_mm >= kTissueMm) return 140;
  return at.y_mm >= kFaintMm && at.y_mm < kFaintMm + 12 ? 50 : 10;
}

class LeastTissueTest : public GpuTest {
 protected:
  /// The depth below the probe of the surface in the middle of the picture.
  double found_mm(double least_tissue, Mode mode) const {
    Scene scene = scene_for(kLayers, layer_angles().front(), layer_angles().back());
    scene.mode = mode;
    scene.camera.target = {.x_mm = 0, .y_mm = 50, .z_mm = 0};
    scene.camera.distance_mm = 50;
    scene.camera.field_mm = 20;
    scene.speckle.filter = SpeckleFilter::kNone;
    scene.detector.threshold = 20;
    scene.detector.least_tissue = least_tissue;
    RenderCounters counters;
    const auto renderer = made_renderer(kLayers, layer_angles(), kSide, scene, counters);
    const Volume volume = made_volume(kLayers, layer_angles(), level_at);
    if (auto loaded = renderer->load(volume); !loaded) throw std::runtime_error(loaded.error().message);
    next_picture(*renderer);
    return renderer->read_depth()->cast_mm[kSide.width * kSide.height / 2 + kSide.width / 2];
  }
};

TEST_F(LeastTissueTest, TakesEveryEdgeWhereNothingIsTooDark) {
  EXPECT_NEAR(found_mm(1, Mode::kSurface), kFaintMm, 0.5);
}

TEST_F(LeastTissueTest, FindsTheTissueBehindAFaintLayer) {
  EXPECT_NEAR(found_mm(60, Mode::kSurface), kTissueMm, 0.5);
}

TEST_F(LeastTissueTest, FindsItWhereTheRayGoesOnBehindTheSurface) {
  for (const Mode mode : {Mode::kVolume, Mode::kMaximum, Mode::kMinimum, Mode::kMean}) {
    EXPECT_NEAR(found_mm(60, mode), kTissueMm, 0.5) << static_cast<int>(mode);
    EXPECT_NEAR(found_mm(1, mode), kFaintMm, 0.5) << static_cast<int>(mode);
  }
}

TEST_F(LeastTissueTest, FindsNothingWhereAllIsTooDark) {
  EXPECT_LT(found_mm(200, Mode::kSurface), 0);
}

TEST_F(LeastTissueTest, AsksTheData) {
  // 0.4 of the way from 10 to 140 is above the layer's 50.
  EXPECT_NEAR(found_mm(0, Mode::kSurface), kTissueMm, 0.5);
}

}  // namespace
}  // namespace fanlight::test::least_tissue_tests
