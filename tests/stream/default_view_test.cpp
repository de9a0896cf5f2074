// SPDX-License-Identifier: Apache-2.0
// The view that the server finds where no one chose one. The test takes the place of the renderer.
#include "server/state/default_view.hpp"

#include <gtest/gtest.h>

#include "server/state/scene_message.hpp"
#include "tests/support/server_fixture.hpp"
#include "tests/support/test_display.hpp"

namespace fanlight::test {
namespace {

using Body = v1::ServerMessage;

/// A DefaultView with its neighbours; the test is the render thread.
class DefaultViewTest : public testing::Test {
 protected:
  static constexpr std::int64_t kLaterNs = DefaultView::kBetweenNs;

  using Outcome = SurveyDesk::Outcome;

  /// Whether a survey was asked for since the last call.
  bool asked() {
    auto order = link_.orders.take();
    if (order) order_ = std::get<VolumeOrder>(*std::move(order));
    return order_.has_value() && order_->number != std::exchange(asked_, order_->number);
  }
  /// Answers, as the render thread and the finder; true: the scene, or the default, differs now.
  bool answer(Outcome outcome, double yaw_deg = 0) {
    outcome_ = outcome;
    yaw_deg_ = yaw_deg;
    answers_.clear();
    const Volume volume(FanGeometry{.columns = 2, .rows = 2}, 1);
    while (order_) {
      auto answered =
          answer_to(*std::exchange(order_, {}), outcome == Outcome::kNoVolume ? nullptr : &volume);
      copier_.answered(std::move(answered));
      if (auto order = link_.orders.take()) order_ = std::get<VolumeOrder>(*std::move(order));
      if (order_) asked_ = order_->number;  // with memory for the copy
    }
    EXPECT_EQ(answers_.size(), 1U);
    EXPECT_EQ(answers_.at(0).asker, SurveyDesk::kServer);
    return view_.answered(answers_.at(0));
  }
  std::optional<FoundSurface> find(const Scene& scene) {
    if (outcome_ == Outcome::kNoMemory) throw std::bad_alloc();
    if (outcome_ != Outcome::kFound) return std::nullopt;
    FoundSurface found{.scene = scene, .choices = {"a sheet"}, .is_sure = is_sure_};
    found.scene.camera.yaw_deg = yaw_deg_;
    return found;
  }
  /// A picture of a volume that was captured just then is shown.
  void shown(std::int64_t now_ns) {
    PictureStamp stamp;
    stamp.volume.first_capture_time_ns = now_ns;
    view_.picture_shown(stamp, now_ns);
  }
  void change_threshold() {
    v1::Scene change;
    change.mutable_detector()->set_threshold(33);
    ASSERT_TRUE(store_.apply(change).value());
  }
  double yaw_deg() const { return store_.in_force().scene.camera.yaw_deg; }
  Mode mode() const { return store_.in_force().scene.mode; }

  static Scene chosen_light() {
    Scene scene;
    scene.light.up_mm = 17;
    return scene;
  }

  Doorbell bell_;
  RenderLink link_{bell_, bell_};
  Mailbox<NumberedScene>& scenes_ = link_.scenes;
  static void run_at_once(EncoderLane, const std::function<void()>& work, const std::function<void()>& done) {
    work();
    done();
  }
  Outcome outcome_ = Outcome::kFound;
  double yaw_deg_ = 0;
  bool is_sure_ = true;
  bool stopped_ = false;
  std::vector<SurveyDesk::Answer> answers_;
  VolumeCopier copier_{link_, run_at_once};
  SceneStore store_{{.revision = 1, .scene = chosen_light()}, Scene{}, scenes_};
  SurveyDesk surveys_{{.find =
                           [this](const Volume&, const Scene& scene, const std::stop_token& stop) {
                             stopped_ = stop.stop_requested();
                             return find(scene);
                           },
                       .volumes = copier_,
                       .executor = run_at_once,
                       .scene_in_force = [this] { return store_.in_force().scene; },
                       .answered = [this](const SurveyDesk::Answer& each) { answers_.push_back(each); }}};
  std::vector<std::string> notes_ = {"angles are assumed"};
  DefaultView view_{true, store_, surveys_, notes_};
  std::optional<VolumeOrder> order_;
  std::uint64_t asked_ = 0;  // number of the newest order that asked() has reported
};

TEST_F(DefaultViewTest, BecomesTheDefaultAndKeepsWhatWasChosen) {
  shown(0);
  ASSERT_TRUE(asked());
  EXPECT_TRUE(answer(SurveyDesk::Outcome::kFound, 25));
  EXPECT_EQ(yaw_deg(), 25);
  EXPECT_EQ(store_.default_scene().camera.yaw_deg, 25);
  EXPECT_EQ(store_.in_force().scene.light.up_mm, 17) << "an option of the command line";
  ASSERT_EQ(notes_.size(), 2U);
  EXPECT_NE(notes_[1].find("found a sheet"), std::string::npos) << notes_[1];
  shown(kLaterNs);
  EXPECT_FALSE(asked()) << "it was found";
}

TEST_F(DefaultViewTest, ShowsSlicesUntilThereIsASurface) {
  shown(0);
  ASSERT_TRUE(asked());
  EXPECT_TRUE(answer(SurveyDesk::Outcome::kNoSurface));
  EXPECT_EQ(mode(), Mode::kSlices);
  ASSERT_EQ(notes_.size(), 2U);
  EXPECT_NE(notes_[1].find("no surface"), std::string::npos) << notes_[1];
  shown(kLaterNs - 1);
  EXPECT_FALSE(asked()) << "a look takes time";
  shown(kLaterNs);
  ASSERT_TRUE(asked());
  EXPECT_FALSE(answer(SurveyDesk::Outcome::kNoSurface)) << "as before";
  shown(2 * kLaterNs);
  ASSERT_TRUE(asked());
  EXPECT_TRUE(answer(SurveyDesk::Outcome::kFound, -12));
  EXPECT_EQ(mode(), Mode::kSurface);
  EXPECT_EQ(notes_.size(), 2U) << "in place of the older one";
  EXPECT_EQ(yaw_deg(), -12);
}

TEST_F(DefaultViewTest, ShowsSlicesBesideASurfaceThatStandsOutLittle) {
  is_sure_ = false;
  shown(0);
  ASSERT_TRUE(asked());
  EXPECT_TRUE(answer(SurveyDesk::Outcome::kFound, 25));
  EXPECT_EQ(mode(), Mode::kSlices);
  EXPECT_EQ(yaw_deg(), 25);
  EXPECT_NE(notes_.back().find("small or torn"), std::string::npos) << notes_.back();
  shown(kLaterNs);
  ASSERT_TRUE(asked());
  EXPECT_FALSE(answer(SurveyDesk::Outcome::kFound, 35)) << "no better";
  shown(2 * kLaterNs);
  ASSERT_TRUE(asked());
  EXPECT_FALSE(answer(SurveyDesk::Outcome::kNoSurface)) << "worse";
  EXPECT_EQ(yaw_deg(), 25);
  is_sure_ = true;
  shown(3 * kLaterNs);
  ASSERT_TRUE(asked());
  EXPECT_TRUE(answer(SurveyDesk::Outcome::kFound, 12));
  EXPECT_EQ(mode(), Mode::kSurface);
  EXPECT_EQ(yaw_deg(), 12);
  shown(4 * kLaterNs);
  EXPECT_FALSE(asked()) << "it was found";
}

TEST_F(DefaultViewTest, EndsWhenSomebodyChangesTheScene) {
  shown(0);
  ASSERT_TRUE(asked());
  change_threshold();
  EXPECT_FALSE(answer(SurveyDesk::Outcome::kFound, 25)) << "changed during the survey";
  EXPECT_EQ(yaw_deg(), 0);
  EXPECT_EQ(notes_.size(), 1U);
  shown(kLaterNs);
  EXPECT_FALSE(asked());
}

TEST_F(DefaultViewTest, LooksAgainAtAnotherGeometry) {
  shown(0);
  ASSERT_TRUE(asked());
  EXPECT_TRUE(answer(SurveyDesk::Outcome::kFound, 25));
  EXPECT_FALSE(view_.source_changed(Scene{}, 1))
      << "the probe told something else, its geometry is as before";
  EXPECT_EQ(yaw_deg(), 25);
  Scene deeper;
  deeper.rays.end_mm = 200;
  EXPECT_TRUE(view_.source_changed(deeper, 10));
  EXPECT_EQ(yaw_deg(), 0);
  EXPECT_EQ(store_.in_force().scene.rays.end_mm, 200);
  EXPECT_EQ(notes_.size(), 1U) << "what was found was found in the geometry before";
  shown(9);
  EXPECT_FALSE(asked()) << "this volume was captured before";
  shown(11);
  ASSERT_TRUE(asked());
  EXPECT_TRUE(answer(SurveyDesk::Outcome::kFound, 30));
  change_threshold();
  deeper.rays.end_mm = 150;
  EXPECT_TRUE(view_.source_changed(deeper, 20));
  EXPECT_EQ(store_.in_force().scene.rays.end_mm, 150);
  shown(21);
  EXPECT_FALSE(asked()) << "someone has chosen the threshold";
}

TEST_F(DefaultViewTest, IgnoresTheAnswerForTheGeometryBefore) {
  shown(0);
  ASSERT_TRUE(asked());
  Scene deeper;
  deeper.rays.end_mm = 200;
  EXPECT_TRUE(view_.source_changed(deeper, 10));
  EXPECT_FALSE(answer(SurveyDesk::Outcome::kFound, 25));
  EXPECT_EQ(yaw_deg(), 0);
  shown(11);
  ASSERT_TRUE(asked());
  EXPECT_TRUE(answer(SurveyDesk::Outcome::kFound, 30));
  EXPECT_EQ(yaw_deg(), 30);
}

TEST_F(DefaultViewTest, LooksLaterWhereTheRendererHasTooManyOrders) {
  while (link_.send(CineOrder())) {
  }
  shown(0);
  const auto refused = surveys_.request(7);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kUnavailable);
  while (link_.orders.take()) {
  }
  shown(1);
  ASSERT_TRUE(asked());
  ASSERT_TRUE(surveys_.request(7)) << "waits for the next survey";
  while (link_.send(CineOrder())) {
  }
  // Memory for the copy is there, and the order with it finds no room; nor does the next survey.
  copier_.answered({.number = order_->number,
                    .outcome = VolumeAnswer::Outcome::kTooSmall,
                    .geometry = {.columns = 2, .rows = 2},
                    .frames = 1});
  ASSERT_EQ(answers_.size(), 2U);
  EXPECT_EQ(answers_[0].asker, SurveyDesk::kServer);
  EXPECT_EQ(answers_[1].asker, 7U);
  for (const SurveyDesk::Answer& each : answers_) EXPECT_EQ(each.outcome, Outcome::kBusy);
}

TEST_F(DefaultViewTest, ASurveyIsStoppedAtTheEnd) {
  shown(0);
  ASSERT_TRUE(asked());
  surveys_.stop();
  answer(Outcome::kNoSurface);
  EXPECT_TRUE(stopped_);
}

TEST_F(DefaultViewTest, KeepsTheViewWhereTheSurveyFailed) {
  shown(0);
  ASSERT_TRUE(asked());
  EXPECT_FALSE(answer(SurveyDesk::Outcome::kNoMemory));
  EXPECT_EQ(mode(), Mode::kSurface);
  shown(kLaterNs);
  EXPECT_TRUE(asked());
}

TEST_F(DefaultViewTest, KeepsAnOptionWithTheDefaultValueAndTellsOfContradictions) {
  const SceneField* const yaw = find_scene_field("camera.yaw_deg");
  const SceneField* const start = find_scene_field("rays.start_mm");
  Scene given;
  given.rays.start_mm = 80;
  SceneStore store({.revision = 1, .scene = given}, Scene{}, scenes_, {yaw, start});
  DefaultView view(true, store, surveys_, notes_);
  view.picture_shown({}, 0);
  ASSERT_TRUE(asked());
  SurveyDesk::Answer found{.outcome = SurveyDesk::Outcome::kFound, .reply = {}};
  Scene scene;
  scene.camera.yaw_deg = 25;
  scene.camera.pitch_deg = 12;
  *found.reply.mutable_found()->mutable_scene() = scene_message(scene);
  EXPECT_TRUE(view.answered(found));
  EXPECT_EQ(store.in_force().scene.camera.yaw_deg, 0) << "an option said so";
  EXPECT_EQ(store.in_force().scene.camera.pitch_deg, 12);

  SceneStore contradicted({.revision = 1, .scene = given}, Scene{}, scenes_, {start});
  DefaultView other(true, contradicted, surveys_, notes_);
  scene.rays.end_mm = 50;
  *found.reply.mutable_found()->mutable_scene() = scene_message(scene);
  EXPECT_TRUE(other.answered(found)) << "the notes say why";
  EXPECT_EQ(contradicted.in_force().scene.camera.pitch_deg, 0);
  EXPECT_NE(notes_.back().find("contradicts the options"), std::string::npos) << notes_.back();
}

TEST_F(DefaultViewTest, DoesNothingWhereAViewWasChosen) {
  DefaultView chosen(false, store_, surveys_, notes_);
  chosen.picture_shown({}, 0);
  EXPECT_FALSE(asked());
}

TEST(DefaultViewStream, ReachesTheDisplays) {
  ServerFixture fixture(StreamServer::Config{.state = {.finds_view = true}});
  TestDisplay display(fixture.endpoint());
  EXPECT_EQ(display.next(Body::kHello).hello().notes_size(), 0);
  fixture.show(1, 100);
  fixture.answer_survey([](Scene scene) {
    scene.camera.yaw_deg = 25;
    return FoundSurface{.scene = scene, .choices = {"a sheet of 80 x 60 mm"}};
  });
  const v1::SceneState scene = display.next(Body::kScene).scene();
  EXPECT_EQ(scene.scene().camera().yaw_deg(), 25);
  EXPECT_EQ(scene.default_scene().camera().yaw_deg(), 25);
  ASSERT_EQ(scene.notes_size(), 1);
  EXPECT_NE(scene.notes(0).find("a sheet of 80 x 60 mm"), std::string::npos);
  TestDisplay later(fixture.endpoint());
  EXPECT_EQ(later.next(Body::kHello).hello().notes_size(), 1);
}

}  // namespace
}  // namespace fanlight::test
