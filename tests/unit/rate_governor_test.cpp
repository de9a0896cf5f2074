// SPDX-License-Identifier: Apache-2.0
// The plan that keeps the picture rate, on a simulated machine with a simulated clock.
#include "renderer/schedule/rate_governor.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "tests/support/milliseconds.hpp"

namespace fanlight {
namespace {

Scene wanting(double rate_hz) {
  Scene scene;
  scene.deadline = {.plan = DeadlinePlan::kHoldRate, .rate_hz = rate_hz};
  return scene;
}

/// A simulated machine that makes one picture after the other; with `streams`, each of a new volume.
class Machine {
 public:
  explicit Machine(double rate_hz) : scene_(wanting(rate_hz)) { governor_.scene_came(scene_, now_ns_); }

  double full_ms = 100;
  double coarse_share = 0.3;
  double wide_share = 0.6;
  double cheap_share = 0.5;
  double light_share = 0;  // of the work, in passes 2 and 3
  bool overlaps = false;   // passes 2 and 3 with pass 1 of the next volume
  bool streams = true;

  /// Makes a picture and returns its measures.
  DeadlineState picture() {
    const DeadlineState state = governor_.in_force(now_ns_);
    const DeadlineMeasures& measures = state.measures;
    const double work_ms = full_ms * (measures.coarse ? coarse_share : 1) *
                           (measures.wide_step ? wide_share : 1) * (measures.cheap_filters ? cheap_share : 1);
    now_ns_ += std::llround(work_ms * kMs);
    if (streams) ++volume_id_;
    PictureStamp stamp{.deadline_level = state.level, .measures = measures, .finished_time_ns = now_ns_};
    stamp.volume.volume_id = volume_id_;
    stamp.stage_ms[static_cast<std::size_t>(Stage::kCast)] = work_ms * (1 - light_share);
    stamp.stage_ms[static_cast<std::size_t>(Stage::kLight)] = work_ms * light_share;
    stamp.passes_overlap = overlaps;
    governor_.picture_finished(stamp);
    return state;
  }
  /// Makes a picture of a changed light.
  void relit_picture(double work_ms) {
    now_ns_ += std::llround(work_ms * kMs);
    PictureStamp stamp{.measures = in_force().measures, .finished_time_ns = now_ns_};
    stamp.volume.volume_id = volume_id_;
    stamp.stage_ms[static_cast<std::size_t>(Stage::kLight)] = work_ms;
    governor_.picture_finished(stamp);
  }
  DeadlineState picture_while_the_camera_moves() {
    change([](Scene& scene) { scene.camera.yaw_deg += 1; });
    return picture();
  }
  /// Makes pictures for that time; returns the sequence of levels in force, without repetitions.
  std::vector<int> levels_over(double seconds) {
    std::vector<int> levels;
    for (const std::int64_t end_ns = now_ns_ + std::llround(seconds * 1e9); now_ns_ < end_ns;) {
      const int level = picture().level;
      if (levels.empty() || levels.back() != level) levels.push_back(level);
    }
    return levels;
  }
  void change(const std::function<void(Scene&)>& by) {
    by(scene_);
    governor_.scene_came(scene_, now_ns_);
  }
  void pass(std::int64_t ns) { now_ns_ += ns; }
  std::int64_t now_ns() const { return now_ns_; }
  DeadlineState in_force() const { return governor_.in_force(now_ns_); }
  const RateGovernor& governor() const { return governor_; }

 private:
  Scene scene_;
  RateGovernor governor_;
  std::int64_t now_ns_ = 5'000'000'000'000;
  std::uint64_t volume_id_ = 1;
};

using Levels = std::vector<int>;

TEST(RateGovernor, CountsTheLongerPartWherePassesOverlap) {
  // 120 ms of work in a period of 100 ms: too much in turn, and enough where 80 and 40 ms run side by side.
  Machine in_turn(10);
  in_turn.full_ms = 120;
  in_turn.light_share = 1.0 / 3;
  EXPECT_GT(in_turn.levels_over(3).size(), 1U);
  Machine beside(10);
  beside.full_ms = 120;
  beside.light_share = 1.0 / 3;
  beside.overlaps = true;
  EXPECT_EQ(beside.levels_over(3), std::vector{0});
}

TEST(RateGovernor, TakesNothingWhereItIsOff) {
  Machine machine(60);
  machine.change([](Scene& scene) { scene.deadline.plan = DeadlinePlan::kOff; });
  EXPECT_EQ(machine.levels_over(20), Levels{0});
  EXPECT_EQ(machine.governor().next_change_ns(machine.now_ns()), std::nullopt);
}

TEST(RateGovernor, TakesNothingWhereTheMachineKeepsUp) {
  Machine machine(15);
  machine.full_ms = 66;
  EXPECT_EQ(machine.levels_over(20), Levels{0});
}

TEST(RateGovernor, LeavesATenthOfRoom) {
  Machine machine(10);
  machine.full_ms = 109;
  EXPECT_EQ(machine.levels_over(20), Levels{0});
  machine.full_ms = 111;
  EXPECT_EQ(machine.levels_over(20), (Levels{0, 1, 2}));
}

TEST(RateGovernor, GoesFromLevelToLevelAsFarAsItMust) {
  Machine machine(10);
  machine.full_ms = 300;  // 90 with coarse rays
  EXPECT_EQ(machine.levels_over(20), (Levels{0, 1, 2}));
  machine.full_ms = 400;  // 72 with a wide step
  EXPECT_EQ(machine.levels_over(20), (Levels{2, 3}));
  machine.full_ms = 800;  // 72 with cheap filters
  EXPECT_EQ(machine.levels_over(20), (Levels{3, 4}));
  EXPECT_EQ(machine.in_force().measures,
            (DeadlineMeasures{.coarse = true, .wide_step = true, .cheap_filters = true}));
  machine.full_ms = 8000;
  EXPECT_EQ(machine.levels_over(60), Levels{4});
}

TEST(RateGovernor, TakesAFewPicturesToDecide) {
  Machine machine(10);
  machine.full_ms = 300;
  for (int picture = 0; picture < 3; ++picture) EXPECT_EQ(machine.picture().level, 0);
  EXPECT_EQ(machine.in_force().level, 1);
}

TEST(RateGovernor, OverlooksASinglePicture) {
  Machine machine(10);
  for (int picture = 0; picture < 60; ++picture) {
    machine.full_ms = picture % 3 == 0 ? 1000 : 90;
    EXPECT_EQ(machine.picture().level, 0);
  }
}

TEST(RateGovernor, GivesBackWhatFits) {
  Machine machine(10);
  machine.full_ms = 1500;
  machine.levels_over(30);
  ASSERT_EQ(machine.in_force().level, 4);
  machine.full_ms = 70;
  EXPECT_EQ(machine.levels_over(30), (Levels{4, 3, 2, 1, 0}));
}

TEST(RateGovernor, StaysWhereTheLevelBelowWouldNotFit) {
  Machine machine(10);
  machine.full_ms = 130;  // 39 with coarse rays
  EXPECT_EQ(machine.levels_over(300), (Levels{0, 1, 2}));
  // The work does not fall to four fifths of the period either.
  machine.full_ms = 85;
  EXPECT_EQ(machine.levels_over(300), Levels{2});
  machine.full_ms = 75;
  EXPECT_EQ(machine.levels_over(300), (Levels{2, 1, 0}));
}

TEST(RateGovernor, ChangesItsMindEverMoreSeldom) {
  // A machine with unpredictable work: every change of the level comes at the wrong time.
  Machine machine(20);
  int changes = 0;
  int pictures = 0;
  std::uint8_t last = 0;
  for (; machine.now_ns() < 5'000'000'000'000 + 300'000 * kMs; ++pictures) {
    machine.full_ms = 100;
    machine.coarse_share = machine.in_force().level >= 2 ? 0.01 : 1;
    machine.wide_share = 1;
    const DeadlineState state = machine.picture();
    changes += state.level != last ? 1 : 0;
    last = state.level;
  }
  EXPECT_LE(changes, 60);
  EXPECT_GT(pictures, 3000);
}

TEST(RateGovernor, IsCoarseWhileTheViewMovesAndFullWhenItRests) {
  Machine machine(10);
  machine.streams = false;
  machine.full_ms = 150;
  for (int picture = 0; picture < 3; ++picture) machine.picture_while_the_camera_moves();
  for (int picture = 0; picture < 20; ++picture) {
    const DeadlineState state = machine.picture_while_the_camera_moves();
    EXPECT_EQ(state, (DeadlineState{.level = 1, .measures = {.coarse = true}}));
  }
  machine.change([](Scene& scene) { scene.camera.yaw_deg += 1; });
  EXPECT_TRUE(machine.in_force().measures.coarse);
  const auto rests_ns = machine.governor().next_change_ns(machine.now_ns());
  EXPECT_EQ(rests_ns, machine.now_ns() + RateGovernor::kMovingNs);
  machine.pass(RateGovernor::kMovingNs);
  EXPECT_EQ(machine.in_force(), (DeadlineState{.level = 1}));
  EXPECT_EQ(machine.governor().next_change_ns(machine.now_ns()), std::nullopt);
  // The full picture of the shown volume is not late, however often the view comes to rest.
  for (int stop = 0; stop < 10; ++stop) {
    machine.picture();
    machine.picture_while_the_camera_moves();
    machine.pass(RateGovernor::kMovingNs);
  }
  EXPECT_EQ(machine.in_force(), (DeadlineState{.level = 1}));
}

TEST(RateGovernor, IsCoarseAtRestWhereVolumesStreamAndFullOnceTheyDoNot) {
  Machine machine(10);
  machine.full_ms = 300;
  machine.levels_over(20);
  ASSERT_EQ(machine.in_force(), (DeadlineState{.level = 2, .measures = {.coarse = true}}));
  const auto still_ns = machine.governor().next_change_ns(machine.now_ns());
  EXPECT_EQ(still_ns, machine.now_ns() + RateGovernor::kStillNs);
  machine.pass(RateGovernor::kStillNs);
  EXPECT_EQ(machine.in_force(), (DeadlineState{.level = 2}));
  // A late full picture does not count.
  machine.streams = false;
  for (int picture = 0; picture < 10; ++picture) machine.picture();
  EXPECT_EQ(machine.in_force().level, 2);
  EXPECT_TRUE(machine.picture_while_the_camera_moves().measures.coarse);
}

TEST(RateGovernor, IsNotConcernedWithAMovedLight) {
  Machine machine(10);
  for (int picture = 0; picture < 50; ++picture) {
    machine.change([](Scene& scene) { scene.light.right_mm += 1; });
    machine.relit_picture(500);
  }
  EXPECT_EQ(machine.in_force(), DeadlineState{});
  machine.full_ms = 300;
  machine.levels_over(20);
  ASSERT_EQ(machine.in_force().level, 2);
  for (int picture = 0; picture < 50; ++picture) machine.relit_picture(5);
  EXPECT_EQ(machine.in_force().level, 2);
}

TEST(RateGovernor, GivesAllBackWhenItIsSwitchedOff) {
  Machine machine(60);
  machine.levels_over(20);
  ASSERT_GT(machine.in_force().level, 0);
  machine.change([](Scene& scene) { scene.deadline.plan = DeadlinePlan::kOff; });
  EXPECT_EQ(machine.in_force(), DeadlineState{});
  machine.change([](Scene& scene) { scene.deadline.plan = DeadlinePlan::kHoldRate; });
  EXPECT_EQ(machine.in_force(), DeadlineState{});
}

TEST(RateGovernor, PlansOnlyWhatItsMeasuresSay) {
  Scene asked = wanting(10);
  asked.filter.size = 9;
  asked.detector.window = 26;
  const auto changed = [&](const DeadlineMeasures& measures) {
    std::vector<std::string_view> names;
    const Scene scene = degraded(asked, measures, 0.25);
    EXPECT_TRUE(check(scene));
    for (const SceneField& field : scene_fields()) {
      if (field.same(asked, scene)) continue;
      names.push_back(field.name);
      Scene allowed;
      EXPECT_TRUE(set_field(allowed, field, field_text(scene, field))) << field.name;
    }
    return names;
  };
  using Names = std::vector<std::string_view>;
  EXPECT_EQ(changed({}), Names{});
  EXPECT_EQ(changed({.coarse = true}), Names{"rays.stride"});
  EXPECT_EQ(changed({.wide_step = true}), (Names{"rays.step_mm", "detector.window"}));
  EXPECT_EQ(changed({.cheap_filters = true}),
            (Names{"speckle.filter", "filter.kind", "filter.islands", "filter.holes"}));
}

TEST(RateGovernor, DoublesTheStepAndKeepsTheWindowsLength) {
  Scene asked;
  const auto wide = [&] { return degraded(asked, {.wide_step = true}, 0.25); };
  EXPECT_EQ(wide().rays.step_mm, 0.5);
  EXPECT_EQ(wide().detector.window, 14);
  asked.rays.step_mm = 0.4;
  asked.detector.window = 2;
  EXPECT_EQ(wide().rays.step_mm, 0.8);
  EXPECT_EQ(wide().detector.window, 2);
  // The finest step that a ray of this length may have.
  asked.rays.step_mm = 0;
  asked.rays.end_mm = 3000;
  EXPECT_NEAR(wide().rays.step_mm, 2 * 3000 / (kMostSamplesOnARay - 1), 1e-9);
  EXPECT_TRUE(check(wide()));
}

TEST(RateGovernorTest, IsCoarseOnlyWhileTheViewMovesWhereThatIsThePlan) {
  RateGovernor governor;
  Scene scene;
  scene.deadline.plan = DeadlinePlan::kSmoothWhileMoving;
  constexpr std::int64_t kSecondNs = 1'000'000'000;
  governor.scene_came(scene, 0);
  EXPECT_FALSE(governor.in_force(0).measures.coarse);
  scene.light.right_mm = 5;
  governor.scene_came(scene, kSecondNs);
  EXPECT_FALSE(governor.in_force(kSecondNs).measures.coarse) << "a moved light casts no ray";
  scene.camera.yaw_deg = 5;
  governor.scene_came(scene, 2 * kSecondNs);
  EXPECT_TRUE(governor.in_force(2 * kSecondNs).measures.coarse);
  EXPECT_EQ(governor.next_change_ns(2 * kSecondNs), 2 * kSecondNs + RateGovernor::kMovingNs);
  EXPECT_FALSE(governor.in_force(2 * kSecondNs + RateGovernor::kMovingNs).measures.coarse);
  PictureStamp slow;
  slow.stage_ms[static_cast<std::size_t>(Stage::kCast)] = 5000;
  for (std::uint64_t volume = 1; volume < 20; ++volume) {
    slow.volume.volume_id = volume;
    slow.finished_time_ns = static_cast<std::int64_t>(volume) * 5 * kSecondNs;
    governor.picture_finished(slow);
  }
  EXPECT_FALSE(governor.in_force(100 * kSecondNs).measures.coarse) << "slow pictures change nothing";
}

}  // namespace
}  // namespace fanlight
