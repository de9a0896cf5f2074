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

FanGeometry convex_lines() {
  FanGeometry geometry = kGeometry;
  geometry.kind = FrameKind::kConvexLines;
  geometry.probe_radius_mm = 40;
  geometry.line_pitch_deg = 0.7;
  return geometry;
}

FanGeometry sector_frames() {
  FanGeometry geometry = kGeometry;
  geometry.probe_radius_mm = 40;
  geometry.sector = {.half_angle_deg = 33, .reach_mm = 0};
  return geometry;
}

FanGeometry of_unknown_beams() {
  FanGeometry geometry = kGeometry;
  geometry.unknown_beams = true;
  return geometry;
}

struct FromAround {
  std::string name;
  FanGeometry geometry;
  Projection projection = Projection::kParallel;
};

class SeenAgainstTheBeamTest : public GpuTest, public testing::WithParamInterface<FromAround> {
 protected:
  const FanGeometry& geometry_ = GetParam().geometry;
  const std::vector<double> angles_rad_ = {-0.4, -0.2, 0, 0.2, 0.4};
  const Scene scene_ = seen(scene_for(geometry_, angles_rad_.front(), angles_rad_.back()));
  const Volume volume_ = made_volume(geometry_, angles_rad_, slab);
  RenderCounters counters_;
  std::unique_ptr<Renderer> renderer_ = made_renderer(geometry_, angles_rad_, {64, 64}, scene_, counters_);
  std::uint64_t revision_ = 1;

  static Scene seen(Scene scene) {
    // The twin takes no values from the data.
    scene.detector.place = SurfacePlace::kRefined;
    scene.detector.frame_steps = FrameSteps::kKept;
    scene.detector.threshold = 30;
    scene.detector.least_contrast = 10;
    scene.camera.projection = GetParam().projection;
    return scene;
  }

  /// The mean certainty of the surface, which is that of the twin.
  double certainty_from(double yaw_deg, double& uncertain_share) {
    Scene scene = scene_;
    scene.camera.yaw_deg += yaw_deg;
    renderer_->show({.revision = ++revision_, .scene = scene});
    const Picture picture = next_picture(*renderer_);
    const TwinCast twin = twin_cast(scene, {64, 64}, twin_prepare(scene.speckle, volume_));
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
    EXPECT_GT(met, picture.certainty.size() / 40) << yaw_deg;
    EXPECT_LE(unlike, met / 50) << yaw_deg;
    uncertain_share = picture.stamp.uncertain_share;
    return sum / static_cast<double>(std::max<std::size_t>(met, 1));
  }
};

TEST_P(SeenAgainstTheBeamTest, IsUncertain) {
  ASSERT_TRUE(renderer_->load(volume_));
  double share = 0;
  EXPECT_GT(certainty_from(0, share), 0.99);
  EXPECT_GT(certainty_from(90, share), 0.9);
  certainty_from(125, share);
  const double oblique = certainty_from(140, share);
  const double behind = certainty_from(180, share);
  if (geometry_.unknown_beams) {
    EXPECT_GT(behind, 0.99);
    EXPECT_LT(share, 0.01);
    return;
  }
  EXPECT_LT(behind, 0.1);
  EXPECT_LT(behind, oblique);
  EXPECT_LT(oblique, 0.9);
  EXPECT_GT(share, 0.99);
}

INSTANTIATE_TEST_SUITE_P(
    Frames, SeenAgainstTheBeamTest,
    testing::Values(FromAround{"Parallel", kGeometry}, FromAround{"Convex", convex_lines()},
                    FromAround{"Sector", sector_frames()}, FromAround{"OfAGrid", of_unknown_beams()},
                    FromAround{"InPerspective", convex_lines(), Projection::kPerspective}),
    [](const testing::TestParamInfo<FromAround>& tested) { return tested.param.name; });

}  // namespace
}  // namespace fanlight::test::surface_id_tests
