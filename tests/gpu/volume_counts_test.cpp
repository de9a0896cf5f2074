// SPDX-License-Identifier: Apache-2.0
// Each volume is counted once: as rendered, as skipped or as refused.
#include <algorithm>

#include "tests/support/gpu_rig.hpp"
#include "tests/support/made_volume.hpp"

namespace fanlight::test::volume_counts_tests {
namespace {

constexpr FanGeometry kGeometry{.columns = 32,
                                .rows = 32,
                                .pixel_width_mm = 3,
                                .pixel_height_mm = 3,
                                .face_column = 15.5,
                                .face_row = 0,
                                .motor_radius_mm = 30};

class VolumeCountsTest : public GpuTest {
 protected:
  void load(std::uint64_t id) {
    Volume volume =
        made_volume(kGeometry, angles_rad_, [](const Point& at) { return at.y_mm > 40 ? 150 : 5; });
    volume.stamp().volume_id = id;
    ASSERT_TRUE(renderer_->load(volume));
  }

  const std::vector<double> angles_rad_ = {-0.4, -0.2, 0, 0.2, 0.4};
  const Scene scene_ = scene_for(kGeometry, angles_rad_.front(), angles_rad_.back());
  RenderCounters counters_;
  std::unique_ptr<Renderer> renderer_ = made_renderer(kGeometry, angles_rad_, {32, 32}, scene_, counters_);
};

TEST_F(VolumeCountsTest, CountsAVolumeOnceHoweverOftenItIsRelitAndCastAgain) {
  load(1);
  next_picture(*renderer_);
  for (std::uint64_t revision = 2; revision < 6; ++revision) {
    Scene scene = scene_;
    scene.light.right_mm = static_cast<double>(revision);
    scene.camera.yaw_deg = revision % 2 == 0 ? 5 : -5;
    renderer_->show({.revision = revision, .scene = scene});
    next_picture(*renderer_);
  }
  EXPECT_EQ(counters_.volumes_rendered.value(), 1U);
  EXPECT_EQ(counters_.volumes_skipped.value(), 0U);
}

TEST_F(VolumeCountsTest, SkipsAVolumeWhosePictureIsDoneAfterThatOfANewerOne) {
  load(2);
  next_picture(*renderer_);
  load(1);
  Picture picture;
  while (renderer_->busy()) {
    ASSERT_TRUE(renderer_->advance());
    EXPECT_FALSE(renderer_->collect(picture));
    ASSERT_TRUE(renderer_->wait(1'000'000'000));
  }
  EXPECT_EQ(counters_.pictures_outdated.value(), 1U);
  EXPECT_EQ(counters_.volumes_rendered.value(), 1U);
  EXPECT_EQ(counters_.volumes_skipped.value(), 1U);
}

TEST_F(VolumeCountsTest, SkipsWhatIsInFlightAtTheEnd) {
  load(1);
  while (!renderer_->wants_volume()) {
    ASSERT_TRUE(renderer_->advance());
    ASSERT_TRUE(renderer_->wait(1'000'000'000));
  }
  load(2);  // while the first volume is being lit
  ASSERT_TRUE(renderer_->advance());
  EXPECT_EQ(counters_.volumes_rendered.value() + counters_.volumes_skipped.value(), 0U);
  renderer_.reset();
  EXPECT_EQ(counters_.volumes_skipped.value(), 2U);
}

}  // namespace
}  // namespace fanlight::test::volume_counts_tests
