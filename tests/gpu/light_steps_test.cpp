// SPDX-License-Identifier: Apache-2.0
// The pieces that passes 2 and 3 are cut into. Uses no GPU.
#include <gtest/gtest.h>

#include "renderer/passes/light_steps.hpp"

namespace fanlight::test::light_steps_tests {
namespace {

/// Three steps of the filter; the light; four steps of the finish.
LightSteps made_steps() {
  LightSteps steps;
  for (int step = 0; step < 3; ++step) steps.add({});
  steps.add({.stage = Stage::kLight});
  for (int step = 0; step < 4; ++step) steps.add({.stage = Stage::kFinish});
  return steps;
}

TEST(LightStepsTest, APieceHasTheStepsThatFitItsTime) {
  const LightSteps steps = made_steps();
  EXPECT_EQ(steps.end_of_piece(1, 2), 2U);
  EXPECT_EQ(steps.end_of_piece(1.5, 2), 1U);
}

TEST(LightStepsTest, APieceHasOneStepWhereNoneFits) {
  EXPECT_EQ(made_steps().end_of_piece(100, 4), 1U);
}

TEST(LightStepsTest, APieceEndsWithItsStage) {
  LightSteps steps = made_steps();
  EXPECT_EQ(steps.end_of_piece(0.1, 4), 3U);
  steps.submit_until(3);
  EXPECT_EQ(steps.end_of_piece(0.1, 4), 4U);
  steps.submit_until(4);
  EXPECT_EQ(steps.end_of_piece(0.1, 4), 8U);
}

TEST(LightStepsTest, KnowsWhetherAllWereSubmitted) {
  LightSteps steps = made_steps();
  steps.submit_until(4);
  EXPECT_FALSE(steps.submitted());
  steps.submit_until(8);
  EXPECT_TRUE(steps.submitted());
  steps.clear();
  EXPECT_TRUE(steps.submitted());
}

TEST(LightStepsTest, KnowsWhichStageWasBegun) {
  LightSteps steps = made_steps();
  steps.submit_until(3);
  EXPECT_TRUE(steps.begun(Stage::kFilter));
  EXPECT_FALSE(steps.begun(Stage::kLight));
  steps.submit_until(4);
  EXPECT_TRUE(steps.begun(Stage::kLight));
  EXPECT_FALSE(steps.begun(Stage::kFinish));
}

TEST(LightStepsTest, DropsWhatFollowsAStage) {
  LightSteps steps = made_steps();
  steps.submit_until(2);
  steps.drop_from(Stage::kLight);
  EXPECT_EQ(steps.count(), 3U);
  EXPECT_EQ(steps.next(), 2U);
  EXPECT_FALSE(steps.submitted());
}

TEST(LightStepsTest, CountsTheStepsOfAStage) {
  const LightSteps steps = made_steps();
  EXPECT_EQ(steps.count_of(Stage::kFilter), 3U);
  EXPECT_EQ(steps.count_of(Stage::kLight), 1U);
  EXPECT_EQ(steps.count_of(Stage::kFinish), 4U);
  EXPECT_EQ(steps.count_of(Stage::kCast), 0U);
}

}  // namespace
}  // namespace fanlight::test::light_steps_tests
