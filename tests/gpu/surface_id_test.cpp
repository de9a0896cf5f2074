// SPDX-License-Identifier: Apache-2.0
// What a picture says of its surface for displays that light it themselves.
#include <cmath>

#include "tests/support/cpu_twin.hpp"
#include "tests/support/gpu_rig.hpp"
#include "tests/support/made_volume.hpp"

namespace fanlight::test::surface_id_tests {
namespace {

const FanGeometry kGeometry{.columns = 96,
                            .rows = 96,
                            .pixel_width_mm = 1,
                            .pixel_height_mm = 1,
                            .face_column = 47.5,
                            .face_row = 0,
                            .motor_radius_mm = 30};

double plate(const Point& at) {
  return at.y_mm > 50 ? 150 : 5;
}

double slab(const Point& at) {
  return at.y_mm > 40 && at.y_mm < 65 && std::abs(at.x_mm) < 30 ? 150 : 5;
}

void collect_into(Renderer& renderer, Picture& picture) {
  while (!renderer.collect(picture)) {
    ASSERT_TRUE(renderer.advance());
    ASSERT_TRUE(renderer.wait(1'000'000'000));
  }
}

class SurfaceIdTest : public GpuTest {
 protected:
  const std::vector<double> angles_rad_ = {-0.4, -0.2, 0, 0.2, 0.4};
  const Scene scene_ = scene_for(kGeometry, angles_rad_.front(), angles_rad_.back());
  RenderCounters counters_;
  std::unique_ptr<Renderer> renderer_ = made_renderer(kGeometry, angles_rad_, {64, 64}, scene_, counters_);

  Picture changed(std::uint64_t revision, const Scene& scene) {
    renderer_->show({.revision = revision, .scene = scene});
    return next_picture(*renderer_);
  }
};

TEST_F(SurfaceIdTest, OfASurfaceSeenAgainstTheBeamIsUncertain) {
  const Volume volume = made_volume(kGeometry, angles_rad_, slab);
  ASSERT_TRUE(renderer_->load(volume));
  Scene seen = scene_;
  // The twin takes no values from the data.
  seen.detector.place = SurfacePlace::kRefined;
  seen.detector.frame_steps = FrameSteps::kKept;
  seen.detector.threshold = 30;
  seen.detector.least_contrast = 10;
  std::uint64_t revision = 1;
  double from_the_side = 0;
  double oblique = 0;
  for (const double yaw_deg : {0.0, 90.0, 125.0, 140.0, 180.0}) {
    seen.camera.yaw_deg = scene_.camera.yaw_deg + yaw_deg;
    const Picture picture = changed(++revision, seen);
    const TwinCast twin = twin_cast(seen, {64, 64}, twin_prepare(seen.speckle, volume));
    const std::vector<float> cast_mm = renderer_->read_depth()->cast_mm;
    std::size_t met = 0;
    std::size_t unlike = 0;
    double sum = 0;
    for (std::size_t pixel = 0; pixel < picture.certainty.size(); ++pixel) {
      if (picture.certainty[pixel] == 0 || std::abs(cast_mm[pixel] - twin.depth_mm[pixel]) > 0.2) continue;
      ++met;
      const double certainty = (picture.certainty[pixel] - 1) / 254.0;
      sum += certainty;
      unlike += std::abs(certainty - twin.certainty[pixel]) > 0.01 ? 1 : 0;
    }
    ASSERT_GT(met, picture.certainty.size() / 20) << yaw_deg;
    EXPECT_LE(unlike, met / 50) << yaw_deg;
    const double mean = sum / static_cast<double>(met);
    if (yaw_deg == 0) EXPECT_GT(mean, 0.99);
    if (yaw_deg == 90) from_the_side = mean;
    if (yaw_deg == 140) oblique = mean;
    if (yaw_deg == 180) {
      EXPECT_LT(mean, 0.1);
      EXPECT_LT(mean, oblique);
      EXPECT_EQ(picture.stamp.uncertain_share, 1);
    }
  }
  EXPECT_GT(from_the_side, 0.9);
  EXPECT_LT(oblique, from_the_side);
}

TEST_F(SurfaceIdTest, IsThatOfTheFilteredMapAndTheCertaintyIsThatOfTheRays) {
  ASSERT_TRUE(renderer_->load(made_volume(kGeometry, angles_rad_, plate)));
  const Picture first = next_picture(*renderer_);
  Scene changing = scene_;
  changing.light.right_mm = 60;
  const Picture lit = changed(2, changing);
  EXPECT_GT(first.stamp.surface_id, 0U);
  EXPECT_EQ(lit.stamp.surface_id, first.stamp.surface_id);
  EXPECT_EQ(lit.certainty, first.certainty);
  // Into a picture that has another surface, or the same one.
  Picture again = blank_picture(1, 1);
  changing.light.right_mm = 50;
  renderer_->show({.revision = 20, .scene = changing});
  collect_into(*renderer_, again);
  EXPECT_EQ(again.depth_mm, first.depth_mm);
  EXPECT_EQ(again.certainty, first.certainty);
  changing.light.right_mm = 40;
  renderer_->show({.revision = 21, .scene = changing});
  collect_into(*renderer_, again);
  EXPECT_EQ(again.stamp.scene_revision, 21U);
  EXPECT_EQ(again.stamp.surface_id, first.stamp.surface_id);
  EXPECT_EQ(again.depth_mm, first.depth_mm);
  changing.filter.kind = DepthFilter::kMean;
  const Picture filtered = changed(22, changing);
  EXPECT_GT(filtered.stamp.surface_id, lit.stamp.surface_id);
  changing.camera.yaw_deg += 5;
  const Picture turned = changed(23, changing);
  EXPECT_GT(turned.stamp.surface_id, filtered.stamp.surface_id);
  const auto depths = renderer_->read_depth();
  ASSERT_EQ(turned.certainty.size(), depths->cast_mm.size());
  std::size_t met = 0;
  for (std::size_t pixel = 0; pixel < turned.certainty.size(); ++pixel) {
    met += turned.certainty[pixel] > 0 ? 1 : 0;
    ASSERT_EQ(turned.certainty[pixel] > 0, depths->cast_mm[pixel] >= 0) << "pixel " << pixel;
  }
  EXPECT_GT(met, turned.certainty.size() / 20);
  const SurfacePart whole{.width = turned.width, .height = turned.height};
  EXPECT_EQ(turned.stamp.view.part, whole);
  changing.mode = Mode::kMaximum;
  EXPECT_EQ(changed(24, changing).stamp.view.part, SurfacePart{});
}

}  // namespace
}  // namespace fanlight::test::surface_id_tests
