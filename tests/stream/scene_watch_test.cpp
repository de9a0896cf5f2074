// SPDX-License-Identifier: Apache-2.0
// Changes of the scene that no picture shows. Time is set by the test.
#include "server/state/scene_watch.hpp"

#include <gtest/gtest.h>

#include "tests/support/milliseconds.hpp"

namespace fanlight::test {
namespace {

using Event = SceneWatch::Event;

class SceneWatchTest : public testing::Test {
 protected:
  void SetUp() override { update(); }

  Event update(std::int64_t ms = 0) {
    now_ns_ += ms * kMs;
    return watch_.update(now_, now_ns_);
  }
  /// Several times a second; the first event that is something.
  Event pass(std::int64_t ms) {
    for (std::int64_t passed = 0; passed < ms; passed += 250)
      if (const Event event = update(250); event != Event::kNone) return event;
    return Event::kNone;
  }

  SceneWatch watch_;
  SceneWatch::Situation now_{.in_force = 1, .shown = 1};
  std::int64_t now_ns_ = 1'000'000 * kMs;
};

TEST_F(SceneWatchTest, ReportsAChangeThatIsNotShownInTwoSecondsOnce) {
  now_.in_force = 2;
  EXPECT_EQ(pass(2000), Event::kNone);
  EXPECT_FALSE(watch_.is_overdue());
  EXPECT_EQ(pass(500), Event::kNotShown);
  EXPECT_TRUE(watch_.is_overdue());
  EXPECT_EQ(pass(60'000), Event::kNone) << "a slow cast is not withdrawn";
  now_.shown = 2;
  EXPECT_EQ(update(), Event::kNone);
  EXPECT_FALSE(watch_.is_overdue());
}

TEST_F(SceneWatchTest, WithdrawsWhatTheRendererRefusesAfterTenSeconds) {
  now_.in_force = now_.refused = 2;
  EXPECT_EQ(pass(4000), Event::kNotShown);
  EXPECT_EQ(pass(7500), Event::kNone);
  EXPECT_EQ(pass(1000), Event::kWithdrawn);
  now_.in_force = 3;  // the scene that is shown
  EXPECT_EQ(update(), Event::kNone);
  EXPECT_FALSE(watch_.is_overdue());
  now_.shown = 3;
  now_.refused = 0;
  EXPECT_EQ(pass(20'000), Event::kNone);
}

TEST_F(SceneWatchTest, AHandThatMovesTheLightIsNeverOverdue) {
  for (int change = 0; change < 1000; ++change) {
    ++now_.in_force;
    now_.shown = now_.in_force - 3;
    ASSERT_EQ(update(100), Event::kNone);
  }
}

TEST_F(SceneWatchTest, AHandDoesNotHideThatNothingIsShown) {
  Event last = Event::kNone;
  int change = 0;
  for (; change < 1000 && last != Event::kWithdrawn; ++change) {
    now_.refused = ++now_.in_force;
    const Event event = update(100);
    if (event != Event::kNone) last = event;
  }
  EXPECT_NEAR(change, 101, 2);
}

TEST_F(SceneWatchTest, TimeWithoutPicturesDoesNotCount) {
  now_.in_force = 2;
  now_.are_pictures_expected = false;
  EXPECT_EQ(pass(60'000), Event::kNone);
  now_.are_pictures_expected = true;
  EXPECT_EQ(pass(1500), Event::kNone);
  EXPECT_EQ(pass(1000), Event::kNotShown);
}

TEST_F(SceneWatchTest, AnOldRefusalIsNoneOfTheNewestChange) {
  now_ = {.in_force = 8, .shown = 7, .refused = 5};
  update();
  EXPECT_EQ(pass(4000), Event::kNotShown);
  EXPECT_EQ(pass(20'000), Event::kNone);
}

}  // namespace
}  // namespace fanlight::test
