// SPDX-License-Identifier: Apache-2.0
#include "acquisition/igtl/pose_history.hpp"

#include <gtest/gtest.h>

#include <string>

namespace fanlight::test {
namespace pose_history_tests {

constexpr std::int64_t kMs = 1'000'000;

igtl::GridPose at_x(double x_mm) {
  return {.first_mm = {x_mm, 0, 0}};
}

TEST(PoseHistory, FindsThePoseOfATime) {
  PoseHistory poses;
  for (int i = 0; i < 5; ++i) poses.add("ProbeToTracker", i * 20 * kMs, at_x(i));
  const auto device = poses.find("ProbeToTracker");
  ASSERT_TRUE(device);
  EXPECT_EQ(poses.at(*device, 40 * kMs).pose->first_mm[0], 2);
  EXPECT_EQ(poses.at(*device, 40 * kMs + 400'000).pose->first_mm[0], 2) << "times are rounded on the way";
  EXPECT_DOUBLE_EQ(poses.at(*device, 50 * kMs).pose->first_mm[0], 2.5) << "between two";
  const auto later = poses.at(*device, 90 * kMs);
  EXPECT_TRUE(later.may_come);
  EXPECT_EQ(later.pose->first_mm[0], 4) << "the nearest so far";
  EXPECT_FALSE(poses.at(*device, 200 * kMs).pose) << "too far";
  EXPECT_FALSE(poses.at(*device, -100 * kMs).pose);
  EXPECT_FALSE(poses.at(*device, -100 * kMs).may_come);
}

TEST(PoseHistory, DoesNotBridgeAGap) {
  PoseHistory poses;
  poses.add("A", 0, at_x(0));
  poses.add("A", 1000 * kMs, at_x(10));
  EXPECT_EQ(poses.at(0, 10 * kMs).pose->first_mm[0], 0);
  EXPECT_EQ(poses.at(0, 990 * kMs).pose->first_mm[0], 10);
  EXPECT_FALSE(poses.at(0, 500 * kMs).pose);
}

TEST(PoseHistory, KeepsDevicesApartAndLimitsThem) {
  PoseHistory poses;
  for (std::size_t i = 0; i < PoseHistory::kMostDevices + 5; ++i)
    poses.add(igtl::DeviceName("D" + std::to_string(i)), 0, at_x(static_cast<double>(i)));
  EXPECT_EQ(poses.devices(), PoseHistory::kMostDevices);
  EXPECT_EQ(poses.at(*poses.find("D3"), 0).pose->first_mm[0], 3);
  EXPECT_FALSE(poses.find("D16"));
}

TEST(PoseHistory, ForgetsTheOldestAndAClockThatWentBack) {
  PoseHistory poses;
  for (std::size_t i = 0; i < PoseHistory::kMostPoses + 10; ++i)
    poses.add("A", static_cast<std::int64_t>(i) * kMs, at_x(static_cast<double>(i)));
  EXPECT_FALSE(poses.at(0, -45 * kMs).pose) << "its neighbours are not kept";
  EXPECT_EQ(poses.at(0, 100 * kMs).pose->first_mm[0], 100);
  poses.add("A", 5 * kMs, at_x(-1));
  EXPECT_FALSE(poses.at(0, 100 * kMs).pose);
  EXPECT_EQ(poses.at(0, 5 * kMs).pose->first_mm[0], -1);
}

}  // namespace pose_history_tests
}  // namespace fanlight::test
