// SPDX-License-Identifier: Apache-2.0
#include "renderer/schedule/private_share.hpp"

#include <gtest/gtest.h>

namespace fanlight::test {
namespace {

constexpr std::int64_t kMs = 1'000'000;

TEST(PrivateShare, HasNoTurnWithoutWork) {
  PrivateShare share;
  EXPECT_FALSE(share.is_turn(false, true, 100 * kMs));
  EXPECT_FALSE(share.is_turn(false, false, 200 * kMs));
}

TEST(PrivateShare, LeavesTheMainViewFourTimesWhatATurnTook) {
  PrivateShare share;
  EXPECT_TRUE(share.is_turn(true, true, 100 * kMs)) << "the main view finishes what is under way";
  EXPECT_TRUE(share.is_turn(true, false, 150 * kMs)) << "from here the time is the private view's";
  share.picture_finished(190 * kMs);
  EXPECT_FALSE(share.is_turn(true, true, 349 * kMs));
  EXPECT_TRUE(share.is_turn(true, true, 350 * kMs)) << "40 ms of its own, and four times that";
}

TEST(PrivateShare, EndsATurnWhoseWorkIsGone) {
  PrivateShare share;
  EXPECT_TRUE(share.is_turn(true, true, 100 * kMs));
  EXPECT_FALSE(share.is_turn(false, true, 120 * kMs)) << "the view was closed";
  EXPECT_TRUE(share.is_turn(true, true, 121 * kMs)) << "it took nothing";
}

TEST(PrivateShare, EndsATurnThatBringsNoPicture) {
  PrivateShare share;
  EXPECT_TRUE(share.is_turn(true, false, 100 * kMs));
  EXPECT_TRUE(share.is_turn(true, false, 1100 * kMs));
  EXPECT_FALSE(share.is_turn(true, false, 1101 * kMs));
  EXPECT_FALSE(share.is_turn(true, false, 5104 * kMs));
  EXPECT_TRUE(share.is_turn(true, false, 5105 * kMs));
}

TEST(PrivateShare, APictureOutsideOfATurnCostsNothing) {
  PrivateShare share;
  share.picture_finished(100 * kMs);
  EXPECT_TRUE(share.is_turn(true, true, 101 * kMs));
}

}  // namespace
}  // namespace fanlight::test
