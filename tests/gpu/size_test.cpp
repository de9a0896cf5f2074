// SPDX-License-Identifier: Apache-2.0
// Pictures of several sizes by one renderer.
#include "tests/support/gpu_rig.hpp"
#include "tests/support/made_volume.hpp"

namespace fanlight::test::size_tests {
namespace {

constexpr PictureSize kUsual{.width = 64, .height = 64};
constexpr PictureSize kFine{.width = 150, .height = 150};
constexpr PictureSize kFinest{.width = 200, .height = 200};

double ball(const Point& at) {
  return std::hypot(at.x_mm, at.y_mm - 50, at.z_mm) < 25 ? 150 : 5;
}
double plate(const Point& at) {
  return at.y_mm > 40 ? 150 : 5;
}

class SizeTest : public GpuTest {
 protected:
  const std::vector<double> angles_rad_ = {-0.4, -0.2, 0, 0.2, 0.4};
  const Scene scene_ = usual_scene();
  RenderCounters counters_;
  std::unique_ptr<Renderer> renderer_ = renderer_of(kUsual, kFinest);

  /// Without windows that are given in pixels.
  Scene usual_scene() const {
    Scene scene = scene_for(kSmallFan, angles_rad_.front(), angles_rad_.back());
    scene.filter.islands = scene.filter.holes = 1;
    return scene;
  }
  std::unique_ptr<Renderer> renderer_of(PictureSize size, std::optional<PictureSize> largest) {
    return made_renderer(kSmallFan, angles_rad_, size, scene_, counters_,
                         {.band_samples = 100'000, .largest_size = largest});
  }
  Volume volume_of(double (*echo)(const Point&)) const { return made_volume(kSmallFan, angles_rad_, echo); }
  Picture shown(std::uint64_t revision, const Scene& scene) {
    renderer_->show({.revision = revision, .scene = scene});
    return next_picture(*renderer_);
  }
  static Scene in_size(Scene scene, PictureSize size) {
    scene.size = size;
    return scene;
  }
  static void expect_same(const Picture& one, const Picture& other) {
    ASSERT_EQ(one.width, other.width);
    EXPECT_EQ(one.rgba, other.rgba);
    EXPECT_EQ(one.depth_mm, other.depth_mm);
    EXPECT_EQ(one.certainty, other.certainty);
    EXPECT_EQ(one.stamp.view.mm_per_pixel, other.stamp.view.mm_per_pixel);
    EXPECT_EQ(one.stamp.view.part, other.stamp.view.part);
    EXPECT_EQ(one.stamp.surface_share, other.stamp.surface_share);
  }
  /// Begins the cast of a finer picture, and submits one band of it.
  void begin_finer(const Scene& scene) {
    renderer_->show({.revision = 1, .scene = in_size(scene, kFinest)});
    ASSERT_TRUE(renderer_->advance());
    ASSERT_TRUE(renderer_->wait(10'000'000'000));
  }
};

TEST_F(SizeTest, PicturesAreThoseOfARendererOfThatSize) {
  const Volume volume = volume_of(ball);
  ASSERT_TRUE(renderer_->load(volume));
  const Picture usual = next_picture(*renderer_);
  EXPECT_EQ(usual.width, kUsual.width);
  for (const PictureSize size : {kFine, kFinest}) {
    const auto other = renderer_of(size, std::nullopt);
    ASSERT_TRUE(other->load(volume));
    expect_same(shown(1, in_size(scene_, size)), next_picture(*other));
  }
  expect_same(shown(1, scene_), usual);
}

TEST_F(SizeTest, AMovedLightCastsNoRayInAFinerPictureEither) {
  ASSERT_TRUE(renderer_->load(volume_of(ball)));
  next_picture(*renderer_);
  shown(1, in_size(scene_, kFine));
  const std::uint64_t casts = counters_.pass1_runs.value();
  Scene lit = in_size(scene_, kFine);
  lit.light.right_mm += 20;
  EXPECT_EQ(shown(2, lit).width, kFine.width);
  EXPECT_EQ(counters_.pass1_runs.value(), casts);
}

TEST_F(SizeTest, ANewVolumeDoesNotWaitForAFinerPictureOfTheLastOne) {
  ASSERT_TRUE(renderer_->load(volume_of(ball)));
  next_picture(*renderer_);
  begin_finer(scene_);
  ASSERT_TRUE(renderer_->wants_volume());
  // The half cast map is lit by no changed light.
  Scene lit = scene_;
  lit.light.right_mm += 20;
  renderer_->show({.revision = 2, .scene = lit});
  const Volume volume = volume_of(plate);
  ASSERT_TRUE(renderer_->load(volume));
  const Picture next = next_picture(*renderer_);
  const auto other = renderer_of(kUsual, std::nullopt);
  other->show({.revision = 2, .scene = lit});
  ASSERT_TRUE(other->load(volume));
  expect_same(next, next_picture(*other));
  EXPECT_EQ(next.stamp.volume.volume_id, volume.stamp().volume_id);
}

TEST_F(SizeTest, ACastThatAPictureWaitsForIsNotGivenUp) {
  ASSERT_TRUE(renderer_->load(volume_of(ball)));
  next_picture(*renderer_);
  Scene turned = scene_;
  turned.camera.yaw_deg += 10;
  begin_finer(turned);
  EXPECT_FALSE(renderer_->wants_volume());
  EXPECT_EQ(next_picture(*renderer_).width, kFinest.width);
}

TEST_F(SizeTest, ASizeWithoutMemoryIsTheUsualOne) {
  ASSERT_TRUE(renderer_->load(volume_of(ball)));
  next_picture(*renderer_);
  EXPECT_EQ(shown(2, in_size(scene_, {.width = 201, .height = 200})).width, kUsual.width);
}

TEST_F(SizeTest, AVolumeThatIsLoadedAgainIsWaitedFor) {
  const Volume first = volume_of(ball);
  const Volume second = volume_of(plate);
  for (const Volume* volume : {&first, &second}) {
    ASSERT_TRUE(renderer_->load(*volume, Renderer::Loading::kKept));
    next_picture(*renderer_);
  }
  renderer_->show({.revision = 1, .scene = in_size(scene_, kFinest)});
  next_picture(*renderer_);
  ASSERT_TRUE(renderer_->load(first, Renderer::Loading::kKept));
  EXPECT_FALSE(renderer_->refines());
  EXPECT_EQ(next_picture(*renderer_).stamp.volume.volume_id, first.stamp().volume_id);
}

TEST_F(SizeTest, APrivateViewHasTheMapOfAFinerPicture) {
  ASSERT_TRUE(renderer_->load(volume_of(ball)));
  next_picture(*renderer_);
  PrivateViews views;
  Doorbell bell;
  Mailbox<Picture> pictures(bell, blank_picture(1, 1));
  views[0] = {.view_id = 7, .scene = {.revision = 1, .scene = scene_}, .pictures = &pictures};
  views[0].scene.scene.light.right_mm += 20;
  ASSERT_TRUE(renderer_->want(views));
  const auto private_picture = [&]() -> Picture {
    for (;;) {
      EXPECT_TRUE(renderer_->advance_private());
      EXPECT_TRUE(renderer_->wait(1'000'000'000));
      renderer_->collect_private();
      if (const Picture* const picture = pictures.newest()) return *picture;
    }
  };
  EXPECT_EQ(private_picture().width, kUsual.width);
  Scene fine = in_size(scene_, kFine);
  shown(2, fine);
  const Picture made = private_picture();
  EXPECT_EQ(made.width, kFine.width);
  fine.light.right_mm += 20;
  EXPECT_EQ(made.rgba, shown(3, fine).rgba);
}

TEST_F(SizeTest, ALargerSizeThanTheMemoryIsRefused) {
  const auto huge = Renderer::create({.size = kUsual,
                                      .largest_size = PictureSize{1U << 20U, 1U << 20U},
                                      .geometry = kSmallFan,
                                      .frame_capacity = 5},
                                     {.gpu = gpu(), .counters = counters_}, {.revision = 1, .scene = scene_});
  ASSERT_FALSE(huge);
  EXPECT_NE(huge.error().message.find("does not fit this GPU"), std::string::npos);
}

}  // namespace
}  // namespace fanlight::test::size_tests
