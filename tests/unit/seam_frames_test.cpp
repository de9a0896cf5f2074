// SPDX-License-Identifier: Apache-2.0
// The frames of a rolling sweep that are blended with the last sweep.
#include <gtest/gtest.h>

#include "renderer/parameters/seam.hpp"

namespace fanlight::test {
namespace {

TEST(NewFramesTest, KeepsTheNewestAngles) {
  NewFrames frames;
  EXPECT_TRUE(frames.angles_rad().empty());
  for (int frame = 0; frame < 20; ++frame) frames.add(0.1 * frame);
  EXPECT_EQ(frames.count(), 20U);
  ASSERT_EQ(frames.angles_rad().size(), std::size_t{FANLIGHT_MOST_SEAM_FRAMES});
  EXPECT_DOUBLE_EQ(frames.angles_rad().front(), 1.9);
  EXPECT_DOUBLE_EQ(frames.angles_rad().back(), 0.4);
}

TEST(NewFramesTest, KnowsThatTheMotorHasTurned) {
  NewFrames frames;
  for (const double angle_rad : {0.1, 0.2, 0.3}) frames.add(angle_rad);
  EXPECT_FALSE(frames.turned());
  for (const double angle_rad : {0.3, 0.2}) frames.add(angle_rad);
  EXPECT_TRUE(frames.turned());
  for (int frame = 0; frame < FANLIGHT_MOST_SEAM_FRAMES; ++frame) frames.add(0.1 - 0.1 * frame);
  EXPECT_FALSE(frames.turned());
}

TEST(SeamTest, TheLastSweepGoesInEqualSteps) {
  EXPECT_DOUBLE_EQ(share_of_last_sweep(0, 3), 0.75);
  EXPECT_DOUBLE_EQ(share_of_last_sweep(1, 3), 0.5);
  EXPECT_DOUBLE_EQ(share_of_last_sweep(2, 3), 0.25);
  EXPECT_DOUBLE_EQ(share_of_last_sweep(3, 3), 0);
  EXPECT_DOUBLE_EQ(share_of_last_sweep(1000, 3), 0);
  EXPECT_DOUBLE_EQ(share_of_last_sweep(0, 0), 0);
}

/// A view along the depth axis, in whose frame the sweep turns about x.
TEST(SeamTest, HasTheSharesOfThePictureBefore) {
  const MapPlace place{
      .view = {.origin_mm = {0, 10, 2}, .right = {1, 0, 0}, .down = {0, 0, 1}, .forward = {0, 1, 0}},
      .size = {.width = 8, .height = 8}};
  Seam seam{.earlier = {.place = place}, .frames = {}, .frame_step_rad = 0.1, .motor_radius_mm = 30};
  for (const double angle_rad : {0.1, 0.2, 0.3, 0.4}) seam.frames.add(angle_rad);
  const auto of = [&](std::uint64_t count_before) { return seam_parameters(place, seam, 3, count_before); };
  const shaders::SeamParameters two = of(2);
  EXPECT_EQ(two.frames, 3);
  EXPECT_EQ(two.same_view, 1);
  EXPECT_FLOAT_EQ(two.along_at_0, 40);
  EXPECT_FLOAT_EQ(two.across_at_0, 2);
  EXPECT_EQ(two.along, glm::vec3(0, 0, 1));
  EXPECT_EQ(two.across, glm::vec3(0, 1, 0));
  EXPECT_FLOAT_EQ(two.frames_per_rad, 10);
  EXPECT_FLOAT_EQ(two.angles[0], 0.4F);
  EXPECT_FLOAT_EQ(two.shares[2], 0.25F);
  EXPECT_FLOAT_EQ(two.shares_before[1], 1) << "it has come since";
  EXPECT_FLOAT_EQ(two.shares_before[2], 0.75F);
  EXPECT_FLOAT_EQ(of(4).shares_before[0], 0.75F) << "no frame has come";
  seam.earlier.place.view.origin_mm[0] = 1;
  EXPECT_EQ(of(4).same_view, 0);
  EXPECT_FLOAT_EQ(of(4).shares_before[2], 0.5F) << "another view counts as a frame";
}

}  // namespace
}  // namespace fanlight::test
