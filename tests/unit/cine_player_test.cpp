// SPDX-License-Identifier: Apache-2.0
#include "renderer/schedule/cine_player.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace fanlight {
namespace {

using Wish = CineOrder::Wish;
constexpr std::int64_t kMs = 1'000'000;

/// Four volumes, 100, 200 and 300 ms apart; frozen at the time 0.
class CinePlayerTest : public testing::Test {
 protected:
  void SetUp() override {
    player_.capture_times_ns() = {1000 * kMs, 1100 * kMs, 1300 * kMs, 1600 * kMs};
    player_.freeze();
  }
  std::uint32_t volume_at(std::int64_t time_ms) {
    player_.advance(time_ms * kMs);
    return player_.volume();
  }
  CinePlayer player_{4};
};

TEST_F(CinePlayerTest, BeginsWithTheNewestAndStays) {
  EXPECT_EQ(volume_at(10'000), 3U);
  EXPECT_FALSE(player_.next_change_ns());
  const CineStatus status = player_.status();
  EXPECT_EQ(status.state, CineStatus::State::kFrozen);
  EXPECT_EQ(status.volumes, 4U);
  EXPECT_DOUBLE_EQ(status.time_s, 0.6);
  EXPECT_DOUBLE_EQ(status.duration_s, 0.6);
}

TEST_F(CinePlayerTest, PlaysByTheCaptureTimesAndRestarts) {
  player_.obey({.wish = Wish::kPlay}, 0);
  // The newest volume stays for the mean of the others, 200 ms.
  const std::vector<std::int64_t> changes_ms = {200, 300, 500, 800, 1000};
  std::uint32_t expected = 3;
  for (const std::int64_t change_ms : changes_ms) {
    EXPECT_EQ(player_.next_change_ns(), change_ms * kMs);
    EXPECT_EQ(volume_at(change_ms - 1), expected);
    expected = (expected + 1) % 4;
    EXPECT_EQ(volume_at(change_ms), expected);
  }
}

TEST_F(CinePlayerTest, PlaysSlowlyAndFast) {
  player_.obey({.wish = Wish::kSeek, .volume = 0}, 0);
  player_.obey({.wish = Wish::kSpeed, .speed = 0.5}, 0);
  player_.obey({.wish = Wish::kPlay}, 0);
  EXPECT_EQ(volume_at(199), 0U);
  EXPECT_EQ(volume_at(200), 1U);
  player_.obey({.wish = Wish::kSpeed, .speed = 4}, 200 * kMs);
  EXPECT_EQ(volume_at(249), 1U);
  EXPECT_EQ(volume_at(250), 2U);
  EXPECT_EQ(player_.status().speed, 4);
}

TEST_F(CinePlayerTest, StepsAroundTheEndsAndPauses) {
  player_.obey({.wish = Wish::kPlay}, 0);
  player_.obey({.wish = Wish::kStep, .volumes = 1}, 0);
  EXPECT_EQ(volume_at(5000), 0U);
  player_.obey({.wish = Wish::kStep, .volumes = -1}, 0);
  EXPECT_EQ(volume_at(5000), 3U);
  player_.obey({.wish = Wish::kStep, .volumes = -1'000'001}, 0);
  EXPECT_EQ(volume_at(5000), 2U);
  player_.obey({.wish = Wish::kSeek, .volume = 99}, 0);
  EXPECT_EQ(volume_at(5000), 3U);
}

TEST_F(CinePlayerTest, GoesOnFromWhereItIsAfterALongStop) {
  player_.obey({.wish = Wish::kPlay}, 0);
  volume_at(3'600'000);
  EXPECT_GT(player_.next_change_ns(), 3'600'000 * kMs);
}

TEST_F(CinePlayerTest, DoesNotWaitForAGap) {
  CinePlayer player(2);
  player.capture_times_ns() = {0, 300'000 * kMs};
  player.freeze();
  player.obey({.wish = Wish::kSeek, .volume = 0}, 0);
  player.obey({.wish = Wish::kPlay}, 0);
  EXPECT_EQ(player.next_change_ns(), 1000 * kMs);
}

TEST_F(CinePlayerTest, StaysAtTheOnlyVolume) {
  CinePlayer player(1);
  player.capture_times_ns() = {5};
  player.freeze();
  player.obey({.wish = Wish::kPlay}, 0);
  player.obey({.wish = Wish::kStep, .volumes = 3}, 0);
  EXPECT_EQ(player.volume(), 0U);
  EXPECT_FALSE(player.next_change_ns());
}

TEST_F(CinePlayerTest, KnowsNothingWhileLive) {
  player_.go_live();
  player_.obey({.wish = Wish::kPlay}, 0);
  player_.obey({.wish = Wish::kSeek, .volume = 2}, 0);
  EXPECT_FALSE(player_.is_frozen());
  EXPECT_EQ(player_.status(), CineStatus{});
}

}  // namespace
}  // namespace fanlight
