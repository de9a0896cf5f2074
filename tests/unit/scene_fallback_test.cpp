// SPDX-License-Identifier: Apache-2.0
// A scene that cannot be drawn, the one before it, and the tries later.
#include <gtest/gtest.h>

#include <cstdint>

#include "renderer/schedule/scene_fallback.hpp"

namespace fanlight::test {
namespace {

constexpr std::int64_t kSecondNs = 1'000'000'000;
const Error kNoPipeline{ErrorCode::kUnavailable, "no memory for a pipeline"};

NumberedScene numbered(std::uint64_t revision) {
  return {.revision = revision, .scene = {}, .deadline = {}};
}

TEST(SceneFallbackTest, ShowsTheWantedScene) {
  SceneFallback scenes(numbered(1));
  scenes.want(numbered(2));
  EXPECT_EQ(scenes.in_force().revision, 2U);
  EXPECT_TRUE(scenes.refusal().empty());
  EXPECT_FALSE(scenes.next_try_ns());
}

TEST(SceneFallbackTest, FallsBackToTheLastSceneThatWasDrawn) {
  SceneFallback scenes(numbered(1));
  scenes.want(numbered(2));
  scenes.note_drawn();
  scenes.want(numbered(3));
  EXPECT_TRUE(scenes.falls_back(kNoPipeline, 0));
  EXPECT_EQ(scenes.in_force().revision, 2U);
  EXPECT_EQ(scenes.wanted().revision, 3U);
  EXPECT_EQ(scenes.refusal(), "no memory for a pipeline");
  EXPECT_EQ(scenes.refused_revision(), 3U);
}

TEST(SceneFallbackTest, ARefusalEndsWhereTheWantedSceneIsBeingCast) {
  SceneFallback scenes(numbered(1));
  scenes.want(numbered(2));
  ASSERT_TRUE(scenes.falls_back(kNoPipeline, 0));
  scenes.note_begun();
  EXPECT_FALSE(scenes.refusal().empty()) << "that is the scene before";
  scenes.want(numbered(3));
  scenes.note_begun();
  EXPECT_TRUE(scenes.refusal().empty()) << "it can be drawn, however long that takes";
}

TEST(SceneFallbackTest, HasNoFallbackForALossOrForTheProvenScene) {
  SceneFallback scenes(numbered(1));
  EXPECT_FALSE(scenes.falls_back(kNoPipeline, 0));
  scenes.want(numbered(2));
  EXPECT_FALSE(scenes.falls_back({ErrorCode::kLost, "lost"}, 0));
  EXPECT_EQ(scenes.in_force().revision, 2U);
}

TEST(SceneFallbackTest, TriesAgainAfterASecondThenTwoThenFour) {
  SceneFallback scenes(numbered(1));
  scenes.want(numbered(2));
  std::int64_t now_ns = 0;
  for (const std::int64_t rest_s : {1, 2, 4}) {
    ASSERT_TRUE(scenes.falls_back(kNoPipeline, now_ns));
    EXPECT_EQ(scenes.next_try_ns(), now_ns + rest_s * kSecondNs);
    now_ns += rest_s * kSecondNs;
    scenes.try_again(now_ns - 1);
    EXPECT_EQ(scenes.in_force().revision, 1U);
    scenes.try_again(now_ns);
    EXPECT_EQ(scenes.in_force().revision, 2U);
  }
}

TEST(SceneFallbackTest, TriesAtLeastOnceInAboutAMinute) {
  SceneFallback scenes(numbered(1));
  scenes.want(numbered(2));
  std::int64_t now_ns = 0;
  for (int tries = 0; tries < 12; ++tries) {
    ASSERT_TRUE(scenes.falls_back(kNoPipeline, now_ns));
    EXPECT_LE(*scenes.next_try_ns() - now_ns, 64 * kSecondNs);
    now_ns = *scenes.next_try_ns();
    scenes.try_again(now_ns);
  }
}

TEST(SceneFallbackTest, ForgetsTheRefusalWithAPictureOfTheWantedScene) {
  SceneFallback scenes(numbered(1));
  scenes.want(numbered(2));
  ASSERT_TRUE(scenes.falls_back(kNoPipeline, 0));
  scenes.note_drawn();
  EXPECT_FALSE(scenes.refusal().empty()) << "a picture of the scene before is no picture of this one";
  scenes.try_again(kSecondNs);
  scenes.note_drawn();
  EXPECT_TRUE(scenes.refusal().empty());
  EXPECT_EQ(scenes.proven().revision, 2U);
}

TEST(SceneFallbackTest, TriesANewSceneAtOnce) {
  SceneFallback scenes(numbered(1));
  scenes.want(numbered(2));
  ASSERT_TRUE(scenes.falls_back(kNoPipeline, 0));
  scenes.want(numbered(3));
  EXPECT_EQ(scenes.in_force().revision, 3U);
}

}  // namespace
}  // namespace fanlight::test
