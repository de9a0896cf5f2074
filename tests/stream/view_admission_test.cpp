// SPDX-License-Identifier: Apache-2.0
// ViewAdmission without sockets: the budget of private views, and when they end. Time is a parameter.
#include "server/state/view_admission.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace fanlight::test {
namespace {

class ViewAdmissionTest : public testing::Test {
 protected:
  static constexpr std::int64_t kMs = 1'000'000;

  static v1::Scene light(double right_mm) {
    v1::Scene scene;
    scene.mutable_light()->set_right_mm(right_mm);
    return scene;
  }
  static v1::Scene yaw(double yaw_deg) {
    v1::Scene scene;
    scene.mutable_camera()->set_yaw_deg(yaw_deg);
    return scene;
  }

  Result<void> change(std::uint64_t session, const v1::Scene& scene) {
    const SceneField* refused = nullptr;
    return admission_.change(session, scene, &refused, now_ns_);
  }
  /// The sentence of the refusal; empty if the change was accepted.
  std::string refusal_of(std::uint64_t session, const v1::Scene& scene) {
    const auto changed = change(session, scene);
    return changed ? "" : changed.error().message;
  }

  /// Most tests are about a main view that has shown pictures before.
  void SetUp() override {
    PictureStamp first;
    first.stage_ms.fill(1);
    admission_.main_shown(first, now_ns_);
  }

  /// The main view shows its next volume after `period_ms`.
  void show_main(double busy_share, double cast_ms, double light_ms, std::int64_t period_ms) {
    now_ns_ += period_ms * kMs;
    render_.main_busy_share.set(busy_share);
    PictureStamp stamp;
    stamp.volume.volume_id = ++volumes_;
    stamp.stage_ms[static_cast<std::size_t>(Stage::kCast)] = cast_ms;
    stamp.stage_ms[static_cast<std::size_t>(Stage::kLight)] = light_ms;
    admission_.main_shown(stamp, now_ns_);
  }

  /// The renderer finishes a picture of a session's view.
  void render(std::uint64_t session, double finish_ms = 1) {
    const PrivateViews& views = *published();
    for (const PrivateView& view : views) {
      if (view.view_id != session) continue;
      Picture& picture = view.pictures->draft();
      picture.stamp = {.view_id = session, .scene_revision = view.scene.revision};
      picture.stamp.volume.volume_id = volumes_;
      picture.stamp.stage_ms[static_cast<std::size_t>(Stage::kFinish)] = finish_ms;
      view.pictures->publish();
    }
  }
  /// The views that the renderer knows; null before the first.
  const PrivateViews* published() {
    if (const PrivateViews* newest = link_.private_views.newest()) published_ = newest;
    return published_;
  }

  std::int64_t now_ns_ = 1'000'000'000'000;
  std::uint64_t volumes_ = 0;
  Doorbell bell_;
  Doorbell render_bell_;
  RenderLink link_{render_bell_, bell_};
  const PrivateViews* published_ = nullptr;
  SceneStore scene_store_{{.revision = 1, .scene = {}}, {}, link_.scenes};
  RenderCounters render_;
  ServerCounters counters_;
  ViewAdmission admission_{
      {.link = link_, .scene_store = scene_store_, .render = render_, .counters = counters_},
      kMostPrivateViews,
      {4, 4}};
};

TEST_F(ViewAdmissionTest, ViewsFitIntoTheTimeThatTheMainViewLeaves) {
  show_main(0.5, 2200, 20, 1000);
  EXPECT_EQ(
      refusal_of(1, yaw(5)),
      "this machine is too busy for a camera of your own: it would take 56 % of the time, and 50 % are "
      "free; expected the camera that all share (a light of your own takes less), a smaller picture, or "
      "a faster machine");
  EXPECT_EQ(refusal_of(1, light(5)), "");
  show_main(0.5, 2200, 600, 1000);
  EXPECT_EQ(
      refusal_of(2, light(5)),
      "this machine is too busy for a light of your own: it would take 30 % of the time, and 20 % are "
      "free, since other displays with views of their own take 30 %; expected fewer displays with views "
      "of their own, a smaller picture, or a faster machine");
  EXPECT_EQ(refusal_of(1, light(6)), "") << "an open view may change its light";
  EXPECT_NE(refusal_of(1, yaw(5)), "") << "but not acquire a camera of its own";
  EXPECT_TRUE(admission_.leave(1));
  EXPECT_EQ(refusal_of(2, light(5)), "") << "the time of the view that ended is free";
}

TEST_F(ViewAdmissionTest, ABusyMainViewLeavesOnePartInFive) {
  show_main(1, 780, 20, 800);
  EXPECT_EQ(refusal_of(1, light(5)), "") << "1 % of 20";
  EXPECT_EQ(refusal_of(2, yaw(5)),
            "this machine is too busy for a camera of your own: it would take 20 % of "
            "the time, and 19 % are free, since other displays with views of their own "
            "take 1 %; expected the camera that all share (a light of your own takes "
            "less), a smaller picture, or a faster machine");
  EXPECT_TRUE(admission_.leave(1));
  EXPECT_EQ(refusal_of(2, yaw(5)), "") << "one picture in four seconds";
}

TEST_F(ViewAdmissionTest, AMainViewWithoutNewPicturesLeavesAllTime) {
  show_main(0.93, 900, 20, 1000);
  EXPECT_NE(refusal_of(1, yaw(5)), "");
  now_ns_ += 1490 * kMs;
  EXPECT_NE(refusal_of(1, yaw(5)), "");
  now_ns_ += 400 * kMs;
  EXPECT_EQ(refusal_of(1, yaw(5)), "");
}

TEST(ViewAdmissionAtTheStart, TheFirstPictureDoesNotCount) {
  // The driver compiles while it is drawn, and a source that stands still shows no second one.
  Doorbell bell;
  RenderLink link(bell, bell);
  SceneStore scene_store({.revision = 1, .scene = {}}, {}, link.scenes);
  RenderCounters render;
  ServerCounters counters;
  ViewAdmission admission({.link = link, .scene_store = scene_store, .render = render, .counters = counters},
                          kMostPrivateViews, {4, 4});
  PictureStamp slow;
  slow.volume.volume_id = 1;
  slow.stage_ms[static_cast<std::size_t>(Stage::kCast)] = 4500;
  v1::Scene turned;
  turned.mutable_camera()->set_yaw_deg(5);
  const SceneField* refused = nullptr;
  constexpr std::int64_t kLaterNs = 100'000'000'000;
  admission.main_shown(slow, 0);
  EXPECT_TRUE(admission.change(1, turned, &refused, kLaterNs));
  admission.main_shown(slow, kLaterNs);
  EXPECT_FALSE(admission.change(2, turned, &refused, 2 * kLaterNs)) << "the second one does";
}

TEST_F(ViewAdmissionTest, TheCostOfAViewIsThatOfItsOwnPictures) {
  ASSERT_TRUE(change(1, light(5)));
  for (int picture = 0; picture < 2; ++picture) {  // the first one does not count
    render(1, 1200);
    now_ns_ += 100 * kMs;
    EXPECT_EQ(admission_.newest(now_ns_).size(), 1U);
  }
  show_main(0.5, 80, 10, 1000);
  EXPECT_NE(refusal_of(1, light(6)).find("would take 60 %"), std::string::npos);
}

TEST_F(ViewAdmissionTest, LimitsTheNumberOfViews) {
  for (std::uint64_t session = 1; session <= kMostPrivateViews; ++session)
    EXPECT_EQ(refusal_of(session, light(5)), "");
  EXPECT_EQ(refusal_of(100, light(5)),
            "4 displays already have a view of their own, expected a later request");
  EXPECT_EQ(counters_.private_views.value(), kMostPrivateViews);
  EXPECT_TRUE(admission_.leave(1));
  EXPECT_FALSE(admission_.leave(1));
  EXPECT_EQ(refusal_of(100, light(5)), "");
}

TEST_F(ViewAdmissionTest, GroupsOfItsOwnStayWhenTheMainViewChanges) {
  ASSERT_TRUE(change(1, light(33)));
  EXPECT_EQ(admission_.state(1).scene().camera().yaw_deg(), Scene{}.camera.yaw_deg);
  ASSERT_TRUE(scene_store_.apply(light(-5)));
  EXPECT_TRUE(admission_.main_changed().empty());
  ASSERT_TRUE(scene_store_.apply(yaw(12)));
  EXPECT_EQ(admission_.main_changed(), std::vector<std::uint64_t>{1});
  EXPECT_EQ(admission_.state(1).scene().light().right_mm(), 33);
  EXPECT_EQ(admission_.state(1).scene().camera().yaw_deg(), 12);
  EXPECT_EQ(published()->at(0).scene.revision, admission_.revision(1));
}

TEST_F(ViewAdmissionTest, LimitsTheRateOfPictures) {
  ASSERT_TRUE(change(1, light(5)));
  render(1);
  EXPECT_EQ(admission_.newest(now_ns_).size(), 1U);
  render(1);
  now_ns_ += ViewAdmission::kBetweenPicturesNs - 1;
  EXPECT_TRUE(admission_.newest(now_ns_).empty());
  EXPECT_TRUE(admission_.has_more());
  now_ns_ += 1;
  EXPECT_EQ(admission_.newest(now_ns_).size(), 1U);
  EXPECT_FALSE(admission_.has_more());
}

TEST_F(ViewAdmissionTest, AViewThatIsBehindForFiveSecondsEnds) {
  show_main(0.5, 80, 10, 1000);
  ASSERT_TRUE(change(1, light(5)));
  for (int second = 0; second < 4; ++second) EXPECT_TRUE(admission_.second_passed(now_ns_).empty()) << second;
  render(1);
  EXPECT_EQ(admission_.newest(now_ns_).size(), 1U);
  for (int second = 0; second < 10; ++second)
    EXPECT_TRUE(admission_.second_passed(now_ns_).empty()) << "up to date";
  show_main(0.5, 80, 10, 1000);
  for (int second = 0; second < 4; ++second) EXPECT_TRUE(admission_.second_passed(now_ns_).empty()) << second;
  const auto ended = admission_.second_passed(now_ns_);
  ASSERT_EQ(ended.size(), 1U);
  EXPECT_EQ(ended[0].session, 1U);
  EXPECT_EQ(ended[0].reason, "this machine had no time for it for 5 s");
  EXPECT_FALSE(admission_.has(1));
  EXPECT_EQ(counters_.private_views.value(), 0U);
}

TEST_F(ViewAdmissionTest, EndsTheDearestViewWhereAllHaveBecomeTooDear) {
  show_main(0.5, 40, 5, 100);
  ASSERT_TRUE(change(1, light(1)));
  ASSERT_TRUE(change(2, light(2)));
  const auto second = [this](double dear_ms) {
    show_main(0.5, 40, 5, 1000);
    now_ns_ += 100 * kMs;
    render(1, 10);
    render(2, dear_ms);
    admission_.newest(now_ns_);
    return admission_.second_passed(now_ns_);
  };
  for (int seconds = 0; seconds < 10; ++seconds) EXPECT_TRUE(second(20).empty()) << "it fits";
  // Many steps of diffusion take 1200 ms, which do not fit into the half that the main view leaves.
  for (int seconds = 0; seconds < 4; ++seconds) EXPECT_TRUE(second(1200).empty()) << "not for long enough";
  const auto ended = second(1200);
  ASSERT_EQ(ended.size(), 1U);
  EXPECT_EQ(ended[0].session, 2U);
  EXPECT_NE(ended[0].reason.find("too busy for it"), std::string::npos) << ended[0].reason;
  EXPECT_TRUE(admission_.has(1));
  EXPECT_FALSE(admission_.has(2));
}

TEST_F(ViewAdmissionTest, LeavesAViewThatTheRendererHasEnded) {
  show_main(0.1, 40, 5, 100);
  ASSERT_TRUE(change(1, light(1)));
  ASSERT_TRUE(change(2, light(2)));
  const std::uint64_t revision = admission_.revision(1);
  const auto end = [this](std::uint64_t view, std::uint64_t of_revision) {
    PrivateViewEnds ends;
    ends[0] = {.view_id = view, .revision = of_revision, .reason = "no memory for it"};
    return admission_.ended_by_renderer(ends);
  };
  EXPECT_TRUE(admission_.ended_by_renderer({}).empty());
  EXPECT_TRUE(end(1, revision - 1).empty()) << "it was changed since, and is opened again";
  const auto ended = end(1, revision);
  ASSERT_EQ(ended.size(), 1U);
  EXPECT_EQ(ended[0].session, 1U);
  EXPECT_EQ(ended[0].reason, "no memory for it");
  EXPECT_FALSE(admission_.has(1));
  EXPECT_TRUE(admission_.has(2));
  EXPECT_TRUE(end(1, revision).empty()) << "once";
}

}  // namespace
}  // namespace fanlight::test
