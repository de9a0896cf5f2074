// SPDX-License-Identifier: Apache-2.0
// Private views: their pictures, their cost, and the precedence of the main view.
#include <algorithm>
#include <cmath>

#include "tests/support/gpu_rig.hpp"
#include "tests/support/made_volume.hpp"

namespace fanlight::test::private_view_tests {
namespace {

const FanGeometry kGeometry{.columns = 96,
                            .rows = 96,
                            .pixel_width_mm = 1,
                            .pixel_height_mm = 1,
                            .face_column = 47.5,
                            .face_row = 0,
                            .motor_radius_mm = 30};

std::vector<double> even_angles() {
  std::vector<double> angles_rad;
  for (int frame = 0; frame < 21; ++frame) angles_rad.push_back(radians(3.0 * frame - 30));
  return angles_rad;
}

double hill(const Point& at) {
  return at.y_mm > 60 - 20 * std::exp(-(at.x_mm * at.x_mm + at.z_mm * at.z_mm) / 200) ? 150 : 5;
}

double higher_hill(const Point& at) {
  return hill({.x_mm = at.x_mm, .y_mm = at.y_mm + 10, .z_mm = at.z_mm});
}

class PrivateViewTest : public GpuTest {
 protected:
  explicit PrivateViewTest(std::uint32_t side = 64)
      : renderer_(made_renderer(kGeometry, angles_rad_, {side, side}, scene_, counters_)) {}

  Volume volume(std::uint64_t id, double (*echo)(const Point&) = hill) const {
    Volume made = made_volume(kGeometry, angles_rad_, echo);
    made.stamp().volume_id = id;
    return made;
  }
  Picture show_volume(std::uint64_t id, double (*echo)(const Point&) = hill) {
    EXPECT_TRUE(renderer_->load(volume(id, echo)));
    return next_picture(*renderer_);
  }
  Picture show(const Scene& scene) {
    renderer_->show({.revision = ++revision_, .scene = scene});
    return next_picture(*renderer_);
  }

  void want(std::size_t index, std::uint64_t view_id, const Scene& scene, bool own_camera) {
    views_[index] = {.view_id = view_id,
                     .scene = {.revision = ++revision_, .scene = scene},
                     .own_camera = own_camera,
                     .pictures = &pictures_[index]};
    ASSERT_TRUE(renderer_->want(views_));
  }

  /// Does what the render thread does while the main view is at rest, until no private view has work left and
  /// every picture is collected. Observes busy() once per round: a piece that ends between two observations
  /// would be missed.
  void let_private_views_finish() {
    for (;;) {
      renderer_->collect_private();
      if (renderer_->busy()) {
        ASSERT_TRUE(renderer_->wait(1'000'000'000));
        continue;
      }
      const auto submitted = renderer_->advance_private();
      ASSERT_TRUE(submitted);
      if (!*submitted) return;
    }
  }
  const Picture* newest(std::size_t index) { return pictures_[index].newest(); }

  const std::vector<double> angles_rad_ = even_angles();
  const Scene scene_ = scene_for(kGeometry, angles_rad_.front(), angles_rad_.back());
  RenderCounters counters_;
  Doorbell bell_;
  std::array<Mailbox<Picture>, kMostPrivateViews> pictures_{Mailbox<Picture>(bell_), Mailbox<Picture>(bell_),
                                                            Mailbox<Picture>(bell_), Mailbox<Picture>(bell_)};
  PrivateViews views_;
  std::uint64_t revision_ = 1;
  std::unique_ptr<Renderer> renderer_;
};

TEST_F(PrivateViewTest, IsAsSteadyAsTheMainView) {
  Scene steady = scene_;
  steady.filter.steady = 0.8;
  show_volume(1);
  show(steady);
  for (std::uint64_t volume_id = 2; volume_id <= 4; ++volume_id) show_volume(volume_id);
  Scene darker = steady;
  darker.finish.exposure = 0.5;
  want(0, 7, darker, false);
  Scene turned = steady;
  turned.camera.yaw_deg += 8;
  want(1, 8, turned, true);
  let_private_views_finish();
  const Picture* const shared = newest(0);
  const Picture* const own = newest(1);
  ASSERT_TRUE(shared != nullptr && own != nullptr);
  for (const Picture* const view : {shared, own}) {
    EXPECT_GT(view->stamp.steady_share, 0.7);
    EXPECT_NEAR(view->stamp.mean_volumes, 4, 0.5);
  }
  EXPECT_EQ(shared->depth_mm, show(darker).depth_mm);
}

TEST_F(PrivateViewTest, OfALightIsThePictureThatTheMainViewWouldShowAndCastsNothing) {
  Scene other = scene_;
  other.light.right_mm = 80;
  other.filter.kind = DepthFilter::kMean;
  other.filter.size = 5;
  other.filter.size_mm = 0;
  other.finish.colours = ColourMap::kSepia;
  show_volume(1);
  const Picture shown = show(other);
  const Picture main = show(scene_);
  const auto casts = counters_.pass1_runs.value();
  want(1, 7, other, false);
  let_private_views_finish();
  const Picture* const own = newest(1);
  ASSERT_NE(own, nullptr);
  EXPECT_EQ(own->rgba, shown.rgba);
  EXPECT_EQ(own->depth_mm, shown.depth_mm);
  EXPECT_NE(own->rgba, main.rgba);
  EXPECT_EQ(own->stamp.view_id, 7U);
  EXPECT_EQ(own->stamp.picture_id, 1U);
  EXPECT_EQ(own->stamp.scene_revision, revision_);
  EXPECT_EQ(own->stamp.volume.volume_id, 1U);
  EXPECT_EQ(own->stamp.stage_ms[static_cast<std::size_t>(Stage::kCast)], 0);
  EXPECT_EQ(counters_.pass1_runs.value() + counters_.private_casts.value(), casts);
  // The main view is unchanged.
  EXPECT_EQ(show(scene_).rgba, main.rgba);
}

TEST_F(PrivateViewTest, OfACameraIsThePictureThatTheMainViewWouldShow) {
  Scene other = scene_;
  other.camera.yaw_deg = 35;
  other.camera.projection = Projection::kPerspective;
  other.light.up_mm = -40;
  show_volume(1);
  const Picture shown = show(other);
  const Picture main = show(scene_);
  want(0, 3, other, true);
  let_private_views_finish();
  const Picture* const own = newest(0);
  ASSERT_NE(own, nullptr);
  EXPECT_EQ(own->rgba, shown.rgba);
  EXPECT_EQ(own->depth_mm, shown.depth_mm);
  EXPECT_EQ(own->stamp.view.forward, shown.stamp.view.forward);
  EXPECT_EQ(counters_.private_casts.value(), 1U);
  EXPECT_EQ(show(scene_).rgba, main.rgba);
  // A changed light of the private view casts nothing.
  other.light.up_mm = 40;
  want(0, 3, other, true);
  let_private_views_finish();
  ASSERT_NE(newest(0), nullptr);
  EXPECT_EQ(counters_.private_casts.value(), 1U);
}

TEST_F(PrivateViewTest, IsDrawnAgainForWhatChangesItAndForNothingElse) {
  Scene blue = scene_;
  blue.light.red = 0.2;
  Scene aside = scene_;
  aside.camera.yaw_deg = 20;
  show_volume(1);
  want(0, 5, blue, false);
  want(1, 6, aside, true);
  let_private_views_finish();
  EXPECT_EQ(counters_.private_pictures.value(), 2U);
  let_private_views_finish();
  EXPECT_EQ(counters_.private_pictures.value(), 2U) << "nothing changed";
  Scene lit = scene_;
  lit.light.right_mm = 10;
  show(lit);
  let_private_views_finish();
  EXPECT_EQ(counters_.private_pictures.value(), 2U) << "the main view's light is none of theirs";
  show_volume(2, higher_hill);
  let_private_views_finish();
  EXPECT_EQ(counters_.private_pictures.value(), 4U) << "the next volume is everybody's";
  EXPECT_EQ(newest(0)->stamp.volume.volume_id, 2U);
  EXPECT_EQ(newest(1)->stamp.volume.volume_id, 2U);
  Scene turned = lit;
  turned.camera.pitch_deg = 15;
  show(turned);
  let_private_views_finish();
  EXPECT_EQ(counters_.private_pictures.value(), 5U) << "a private light is on the main view's camera";
  want(0, 0, blue, false);
  show_volume(3);
  let_private_views_finish();
  EXPECT_EQ(counters_.private_pictures.value(), 6U) << "one is gone";
}

TEST_F(PrivateViewTest, GoesOverFromALightToACameraAndBack) {
  Scene other = scene_;
  other.light.right_mm = 50;
  show_volume(1);
  want(0, 5, other, false);
  let_private_views_finish();
  const std::vector<std::uint8_t> lit = newest(0)->rgba;
  Scene aside = other;
  aside.camera.yaw_deg = 30;
  want(0, 5, aside, true);
  let_private_views_finish();
  EXPECT_NE(newest(0)->rgba, lit);
  want(0, 8, other, false);
  let_private_views_finish();
  const Picture* const back = newest(0);
  EXPECT_EQ(back->rgba, lit);
  EXPECT_EQ(back->stamp.view_id, 8U);
}

class LargePrivateViewTest : public PrivateViewTest {
 protected:
  LargePrivateViewTest() : PrivateViewTest(384) {}

  /// The costliest passes 2 and 3 that may be asked for.
  Scene costly_light() const {
    Scene scene = scene_;
    scene.filter.kind = DepthFilter::kEdgePreserving;
    scene.filter.size = 31;
    scene.filter.size_mm = 0;
    scene.finish.smoothing = Smoothing::kDiffusion;
    scene.finish.iterations = 30;
    return scene;
  }

  /// Submits one piece of a private view's work and waits until it is done.
  void one_piece() {
    const auto submitted = renderer_->advance_private();
    ASSERT_TRUE(submitted);
    ASSERT_TRUE(*submitted);
    EXPECT_FALSE(renderer_->main_busy());
    ++pieces_;
    while (renderer_->busy()) {
      ASSERT_TRUE(renderer_->wait(1'000'000'000));
      renderer_->collect_private();
    }
  }

  int pieces_ = 0;
};

TEST_F(LargePrivateViewTest, GivesWayToTheMainViewPieceByPiece) {
  Scene aside = scene_;
  aside.camera.yaw_deg = 20;
  aside.rays.step_mm = 0.1;
  show_volume(1);
  want(0, 5, aside, true);
  one_piece();
  one_piece();
  EXPECT_EQ(newest(0), nullptr) << "the cast has more pieces than two";
  // The next volume goes to the other slot. The private cast continues afterwards, on the volume that it
  // began with.
  const Picture second = show_volume(2, higher_hill);
  EXPECT_EQ(second.stamp.volume.volume_id, 2U);
  one_piece();
  EXPECT_EQ(counters_.private_casts_given_up.value(), 0U);
  // The third volume takes the slot of the private cast.
  EXPECT_EQ(show_volume(3).stamp.volume.volume_id, 3U);
  one_piece();
  EXPECT_EQ(counters_.private_casts_given_up.value(), 1U);
  let_private_views_finish();
  const Picture* const own = newest(0);
  ASSERT_NE(own, nullptr);
  EXPECT_EQ(own->stamp.volume.volume_id, 3U);
  EXPECT_GT(pieces_, 3);
  EXPECT_EQ(own->rgba, show(aside).rgba) << "whole, and of one volume";
}

TEST_F(LargePrivateViewTest, LightsInPiecesBetweenWhichTheMainViewIsLit) {
  show_volume(1);
  const Scene costly = costly_light();
  want(0, 5, costly, false);
  Scene lit = scene_;
  while (counters_.private_pictures.value() == 0) {
    one_piece();
    if (pieces_ % 10 != 3) continue;
    lit.light.right_mm += 5;
    EXPECT_EQ(show(lit).stamp.scene_revision, revision_);
  }
  EXPECT_GT(pieces_, 20) << "the time of a step is not known yet, so each is a piece";
  const Picture* const picture = newest(0);
  ASSERT_NE(picture, nullptr);
  const std::vector<std::uint8_t> own = picture->rgba;
  const auto cost_ms = [&](Stage stage) { return picture->stamp.stage_ms[static_cast<std::size_t>(stage)]; };
  EXPECT_GT(cost_ms(Stage::kFilter), 0);
  EXPECT_GT(cost_ms(Stage::kLight), 0);
  EXPECT_GT(cost_ms(Stage::kFinish), 0);
  EXPECT_EQ(cost_ms(Stage::kCast), 0);
  EXPECT_EQ(own, show(costly).rgba);
  EXPECT_EQ(counters_.private_lights_given_up.value(), 0U);
}

TEST_F(LargePrivateViewTest, FinishesALightWhoseDepthMapAndFramesAreReplacedAtOnce) {
  show_volume(1);
  Scene costly = costly_light();
  costly.filter.weights = FilterWeights::kConfidence;
  const Picture first = show(costly);
  show(scene_);
  want(0, 5, costly, false);
  one_piece();
  Scene turned = scene_;
  turned.camera.yaw_deg = 25;
  show(turned);
  // Volumes go to two slots by turns.
  show_volume(2, higher_hill);
  show_volume(3, higher_hill);
  while (counters_.private_pictures.value() == 0) one_piece();
  const Picture* const own = newest(0);
  ASSERT_NE(own, nullptr);
  EXPECT_EQ(own->stamp.volume.volume_id, 1U);
  EXPECT_EQ(own->rgba, first.rgba);
  let_private_views_finish();
  const Picture* const next = newest(0);
  ASSERT_NE(next, nullptr);
  EXPECT_EQ(next->stamp.volume.volume_id, 3U);
  costly.camera = turned.camera;
  EXPECT_EQ(next->rgba, show(costly).rgba);
  EXPECT_EQ(counters_.private_lights_given_up.value(), 0U);
}

TEST_F(LargePrivateViewTest, EndsInTheMidstOfItsLightWhereNobodyWantsItAnyMore) {
  show_volume(1);
  want(0, 5, costly_light(), false);
  one_piece();
  want(0, 0, costly_light(), false);
  let_private_views_finish();
  EXPECT_EQ(newest(0), nullptr);
  EXPECT_EQ(counters_.private_lights_given_up.value(), 1U);
  want(0, 6, scene_, false);
  let_private_views_finish();
  const Picture* const own = newest(0);
  ASSERT_NE(own, nullptr);
  EXPECT_EQ(own->rgba, show(scene_).rgba);
}

TEST_F(LargePrivateViewTest, EndsInTheMidstOfItsCastWhereNobodyWantsItAnyMore) {
  Scene aside = scene_;
  aside.camera.yaw_deg = 20;
  aside.rays.step_mm = 0.1;
  show_volume(1);
  want(0, 5, aside, true);
  const auto submitted = renderer_->advance_private();
  ASSERT_TRUE(submitted);
  ASSERT_TRUE(*submitted);
  want(0, 0, aside, true);
  let_private_views_finish();
  EXPECT_EQ(newest(0), nullptr);
  EXPECT_EQ(counters_.private_casts_given_up.value(), 1U);
  EXPECT_EQ(show_volume(2).stamp.volume.volume_id, 2U);
}

}  // namespace
}  // namespace fanlight::test::private_view_tests
