// SPDX-License-Identifier: Apache-2.0
// The size of pictures, on a simulated machine with a simulated clock.
#include "renderer/schedule/size_governor.hpp"

#include <gtest/gtest.h>

#include "tests/support/milliseconds.hpp"

namespace fanlight {
namespace {

constexpr PictureSize kUsual{.width = 512, .height = 512};
constexpr PictureSize kMost{.width = 2048, .height = 2048};
constexpr PictureSize kShown{.width = 900, .height = 1000};
constexpr PictureSize kFine{.width = 900, .height = 900};

class SizeGovernorTest : public testing::Test {
 protected:
  SizeGovernor governor_{kUsual, kMost};
  std::int64_t now_ns_ = 10'000'000'000;
  NumberedScene scene_{.revision = 1, .scene = {}};
  double usual_ms_ = 200;
  double light_share_ = 0.25;
  std::uint64_t volume_ = 0;

  SizeGovernorTest() {
    governor_.scene_came(scene_, now_ns_);
    governor_.want({.of_surfaces = kShown, .of_pictures = {}});
  }

  void pass_ms(double ms) { now_ns_ += static_cast<std::int64_t>(ms * 1e6); }
  std::optional<PictureSize> size() const { return governor_.in_force(now_ns_); }
  void move() {
    ++scene_.revision;
    scene_.scene.camera.yaw_deg += 1;
    governor_.scene_came(scene_, now_ns_);
  }
  void move_light() {
    ++scene_.revision;
    scene_.scene.light.right_mm += 1;
    governor_.scene_came(scene_, now_ns_);
  }
  /// A picture in the size in force; returns its size. `coarse`: as the deadline plan makes it.
  PictureSize picture(bool coarse = false) {
    const PictureSize size = governor_.in_force(now_ns_).value_or(kUsual);
    Picture made{.width = size.width, .height = size.height};
    const double ms = usual_ms_ * static_cast<double>(size.pixels()) / static_cast<double>(kUsual.pixels());
    pass_ms(ms);
    made.stamp.scene_revision = scene_.revision;
    made.stamp.measures.coarse = coarse;
    made.stamp.volume.volume_id = volume_;
    made.stamp.stage_ms[static_cast<std::size_t>(Stage::kCast)] = (1 - light_share_) * ms;
    made.stamp.stage_ms[static_cast<std::size_t>(Stage::kLight)] = light_share_ * ms;
    made.stamp.finished_time_ns = now_ns_;
    governor_.picture_finished(made);
    return size;
  }
  PictureSize volume() {
    ++volume_;
    governor_.volume_came(now_ns_);
    return picture();
  }
  /// Volumes that come at that rate; the size of the last one's picture.
  PictureSize stream(int volumes, double period_ms) {
    PictureSize last;
    for (int each = 0; each < volumes; ++each) {
      const std::int64_t began_ns = now_ns_;
      last = volume();
      now_ns_ = std::max(now_ns_, began_ns + static_cast<std::int64_t>(period_ms * 1e6));
    }
    return last;
  }
};

TEST_F(SizeGovernorTest, IsTheUsualOneWhereNoDisplayAsksForMore) {
  governor_.want({});
  volume();
  pass_ms(60'000);
  EXPECT_EQ(size(), std::nullopt);
  governor_.want({.of_surfaces = kUsual, .of_pictures = kUsual});
  EXPECT_EQ(size(), std::nullopt);
  EXPECT_EQ(governor_.next_change_ns(now_ns_), std::nullopt);
}

TEST_F(SizeGovernorTest, ASlowMachineRefinesWhatRests) {
  EXPECT_EQ(volume(), kUsual);
  EXPECT_EQ(size(), std::nullopt) << "the next volume may come";
  const auto change_ns = governor_.next_change_ns(now_ns_);
  ASSERT_TRUE(change_ns);
  pass_ms(5000);
  EXPECT_EQ(size(), kFine) << "in the proportions of the usual size";
  EXPECT_EQ(picture(), kFine);
  EXPECT_EQ(size(), kFine) << "it stays";
}

TEST_F(SizeGovernorTest, FrozenVolumesRestSooner) {
  governor_.set_frozen(true);
  volume();
  pass_ms(SizeGovernor::kRestNs / 1e6 + 1);
  EXPECT_EQ(size(), kFine);
  EXPECT_EQ(picture(), kFine);
  EXPECT_EQ(volume(), kUsual) << "a step shows the next volume quickly";
}

TEST_F(SizeGovernorTest, AMovedViewIsUsualUntilItRestsAndWasShownWhole) {
  governor_.set_frozen(true);
  volume();
  pass_ms(1000);
  picture();
  move();
  EXPECT_EQ(size(), std::nullopt);
  picture(true);
  pass_ms(1000);
  EXPECT_EQ(size(), std::nullopt) << "a coarse picture is on show";
  EXPECT_EQ(picture(), kUsual);
  EXPECT_EQ(size(), kFine);
}

TEST_F(SizeGovernorTest, AMovedLightDelaysTheFinePictureAndKeepsOneThatIsThere) {
  governor_.set_frozen(true);
  volume();
  pass_ms(550);
  move_light();
  pass_ms(100);
  EXPECT_EQ(size(), std::nullopt);
  pass_ms(550);
  EXPECT_EQ(picture(), kFine);
  move_light();
  EXPECT_EQ(size(), kFine) << "a moved light casts no ray";
}

TEST_F(SizeGovernorTest, AQuickMachineIsAlwaysFine) {
  usual_ms_ = 3;
  stream(3, 40);
  EXPECT_EQ(stream(5, 40), kFine);
  move();
  EXPECT_EQ(size(), kFine);
}

TEST_F(SizeGovernorTest, IsFineBetweenVolumesWhereItFits) {
  usual_ms_ = 100;  // 310 ms
  EXPECT_EQ(stream(5, 400), kUsual);
  EXPECT_EQ(stream(30, 800), kFine);
  move();
  EXPECT_EQ(size(), std::nullopt);
}

TEST_F(SizeGovernorTest, IsGivenUpForAWhileWhereItTakesTooLong) {
  usual_ms_ = 100;
  stream(30, 800);
  usual_ms_ = 400;  // the machine has other work
  EXPECT_EQ(stream(2, 800), kUsual);
  usual_ms_ = 100;
  EXPECT_EQ(stream(5, 800), kUsual);
  EXPECT_EQ(stream(15, 800), kFine);
}

TEST_F(SizeGovernorTest, HoldRateLeavesRoomForItsPeriod) {
  usual_ms_ = 50;  // 155 ms
  EXPECT_EQ(stream(10, 400), kFine);
  ++scene_.revision;
  scene_.scene.deadline = {.plan = DeadlinePlan::kHoldRate, .rate_hz = 4};
  governor_.scene_came(scene_, now_ns_);
  EXPECT_EQ(stream(10, 400), kUsual);
}

TEST_F(SizeGovernorTest, ReplacedFramesHaveTheUsualSize) {
  usual_ms_ = 3;
  stream(5, 40);
  EXPECT_EQ(size(), kFine);
  ++scene_.revision;
  scene_.scene.refresh = Refresh::kFrame;
  governor_.scene_came(scene_, now_ns_);
  pass_ms(10'000);
  EXPECT_EQ(size(), std::nullopt);
}

TEST_F(SizeGovernorTest, ARendererThatWasMadeAgainMayHaveLessRoom) {
  governor_.set_frozen(true);
  volume();
  pass_ms(1000);
  EXPECT_EQ(size(), kFine);
  governor_.set_largest(kUsual);
  EXPECT_EQ(size(), std::nullopt);
}

TEST_F(SizeGovernorTest, APictureThatTheServerLightsIsLitSoon) {
  governor_.set_frozen(true);
  governor_.want({.of_surfaces = {}, .of_pictures = kMost});
  volume();
  pass_ms(1000);
  const auto limited = size();
  ASSERT_TRUE(limited);
  EXPECT_NEAR(static_cast<double>(limited->pixels()) / static_cast<double>(kUsual.pixels()),
              SizeGovernor::kMostLightMs / (light_share_ * usual_ms_), 0.05);
  governor_.want({.of_surfaces = kShown, .of_pictures = kMost});
  EXPECT_EQ(size(), kFine) << "a display that lights it itself waits for no light";
  scene_.scene.glass.amount = 0.5;
  governor_.scene_came(scene_, now_ns_);
  volume();
  pass_ms(1000);
  EXPECT_EQ(size(), limited) << "the server lights glass for all";
  scene_.scene.glass.amount = 0;
  governor_.scene_came(scene_, now_ns_);
  light_share_ = 0.6;  // a light of 120 ms
  governor_.want({.of_surfaces = {}, .of_pictures = kMost});
  volume();
  pass_ms(1000);
  EXPECT_EQ(size(), std::nullopt);
}

TEST_F(SizeGovernorTest, IsNeverSoLargeThatItTakesTooLong) {
  governor_.want({.of_surfaces = kMost, .of_pictures = {}});
  governor_.set_frozen(true);
  usual_ms_ = 300;
  volume();
  pass_ms(1000);
  const auto limited = size();
  ASSERT_TRUE(limited);
  EXPECT_NEAR(static_cast<double>(limited->pixels()) / static_cast<double>(kUsual.pixels()),
              SizeGovernor::kMostWorkMs / 300, 0.05);
  const PictureSize before = *limited;
  usual_ms_ = 200;
  EXPECT_EQ(picture(), before);
  EXPECT_EQ(size(), before) << "the time of a fine picture does not change its size";
}

TEST_F(SizeGovernorTest, AFirstPictureThatPaidForTheShadersDoesNotKeepThoseAtRestCoarse) {
  governor_.want({.of_surfaces = kMost, .of_pictures = {}});
  governor_.set_frozen(true);
  usual_ms_ = 5000;  // by which no larger one would fit
  volume();
  pass_ms(1000);
  usual_ms_ = 50;
  EXPECT_NEAR(static_cast<double>(picture().width) / kUsual.width, 1.2, 0.01);
  EXPECT_EQ(size(), kMost) << "by what the tried one took";
  EXPECT_EQ(picture(), kMost);
  EXPECT_EQ(size(), kMost);
}

TEST_F(SizeGovernorTest, ASlowMachineTriesOneLargerPictureAndKeepsIt) {
  governor_.want({.of_surfaces = kMost, .of_pictures = {}});
  governor_.set_frozen(true);
  usual_ms_ = 2000;
  volume();
  pass_ms(1000);
  const PictureSize tried = picture();
  EXPECT_GT(tried.width, kUsual.width);
  EXPECT_EQ(size(), tried);
  volume();
  pass_ms(1000);
  EXPECT_EQ(size(), std::nullopt) << "what a picture takes is known now";
}

}  // namespace
}  // namespace fanlight
