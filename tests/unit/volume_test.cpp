// SPDX-License-Identifier: Apache-2.0
#include "proto/model/volume.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace fanlight {
namespace {

using Numbers = std::vector<std::uint64_t>;

class VolumeTest : public testing::Test {
 protected:
  static constexpr std::uint32_t kCapacity = 4;

  void add(std::uint64_t commit_number, double angle_rad) {
    volume_.add_frame(
        {.sequence = 100 + commit_number, .angle_rad = angle_rad, .commit_number = commit_number});
  }

  Volume volume_{{.columns = 4, .rows = 3, .pixel_width_mm = 1, .pixel_height_mm = 1, .motor_radius_mm = 30},
                 kCapacity};
};

TEST_F(VolumeTest, KeepsTheNumberOfEachFrame) {
  EXPECT_TRUE(volume_.commit_numbers().empty());
  const std::uint64_t* const memory = volume_.commit_numbers().data();
  add(41, 0.3);
  add(42, 0.2);
  add(44, 0.1);
  add(0, 0.0);  // not known
  EXPECT_TRUE(volume_.full());
  EXPECT_TRUE(std::ranges::equal(volume_.commit_numbers(), Numbers{41, 42, 44, 0}));
  EXPECT_EQ(volume_.commit_numbers().data(), memory) << "taken by the constructor";
}

TEST_F(VolumeTest, NumbersStayInTheOrderOfArrival) {
  add(1, 0.3);
  add(2, 0.2);
  add(3, 0.1);
  volume_.turn_by(0.01);
  volume_.sort_by_angle();
  EXPECT_TRUE(std::ranges::equal(volume_.commit_numbers(), Numbers{1, 2, 3}));
  EXPECT_EQ(volume_.commit_numbers()[volume_.by_angle()[0]], 3U);
}

TEST_F(VolumeTest, FramesTakenOutTakeTheirNumbersAlong) {
  add(1, 0.1);
  add(2, 0.2);
  add(3, 0.3);
  volume_.keep_first(2, {.sequence = 102, .angle_rad = 0.2, .commit_number = 2});
  EXPECT_TRUE(std::ranges::equal(volume_.commit_numbers(), Numbers{1, 2}));
  add(4, 0.4);
  EXPECT_TRUE(std::ranges::equal(volume_.commit_numbers(), Numbers{1, 2, 4}));
  volume_.clear();
  EXPECT_TRUE(volume_.commit_numbers().empty());
}

}  // namespace
}  // namespace fanlight
