// SPDX-License-Identifier: Apache-2.0
// Sweeps that end where the angle reverses.
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "tests/assembler/assembler_fixture.hpp"

namespace fanlight {
namespace {

constexpr std::uint32_t kFrames = 30;

class TurningTest : public AssemblerTest {
 protected:
  TurningTest()
      : AssemblerTest({.capacity = 48,
                       .config = {.cut = SweepCut::kByTurning,
                                  .range = {radians(-30), radians(30)},
                                  .correction = MismatchCorrection::kOff}}) {}

  bool add_angle(double angle_deg) {
    return add({.sequence = sequence_++,
                .volume_index = 77,  // not read, like all indices of the stamp
                .frame_index = 5,
                .frames_in_sweep = 3,
                .angle_rad = radians(angle_deg),
                .capture_time_ns = static_cast<std::int64_t>(1000 * sequence_)});
  }

  /// From one angle to another in steps of 2 deg, both included, with jitter.
  void sweep(int from, int to, double jitter_deg = 0) {
    std::uniform_real_distribution<double> jitter(-jitter_deg, jitter_deg);
    const int way = to > from ? 1 : -1;
    for (int place = from; place != to + way; place += way) {
      EXPECT_TRUE(add_angle(2.0 * place + (jitter_deg > 0 ? jitter(random_) : 0)));
    }
  }

  /// Takes the volumes published since the last call and passes each to `look`.
  template <typename Look>
  void take(Look look) {
    while (const auto volume = ring_.take()) look(*volume);
  }

  std::mt19937 random_{11};
};

TEST_F(TurningTest, CutsAtTheTurnAndMovesTheFramesAfterIt) {
  sweep(-15, 14);
  EXPECT_EQ(published(), 0U);
  sweep(14, -15);
  ASSERT_EQ(published(), 1U);
  const auto first = ring_.take();
  EXPECT_EQ(first->stamp().frames, kFrames);
  EXPECT_EQ(first->stamp().direction, SweepDirection::kForward);
  EXPECT_EQ(first->stamp().last_frame_sequence, kFrames - 1);
  EXPECT_EQ(first->stamp().last_capture_time_ns, 1000 * kFrames);
  EXPECT_EQ(first->stamp().source_volume_index, 0U);
  sweep(-15, -10);
  ASSERT_EQ(published(), 2U);
  const auto second = ring_.take();
  EXPECT_EQ(second->stamp().frames, kFrames);
  EXPECT_EQ(second->stamp().direction, SweepDirection::kBackward);
  EXPECT_EQ(second->stamp().first_frame_sequence, kFrames);
  EXPECT_EQ(second->stamp().source_volume_index, 1U);
  for (std::uint32_t i = 0; i < kFrames; ++i) {
    EXPECT_EQ(second->frame_pixels(i)[0], kFrames + i);
    EXPECT_NEAR(degrees(second->angles_rad()[i]), 28 - 2.0 * i, 1e-9);
  }
  EXPECT_EQ(second->stamp().frames_missing, 0U);
  expect_identity();
}

TEST_F(TurningTest, BearsJitterAndEarlyAndLateTurning) {
  std::uniform_int_distribution<int> end(9, 16);
  int from = -15;
  std::vector<std::uint32_t> lengths;
  for (int i = 0; i < 200; ++i) {
    const int to = i % 2 == 0 ? end(random_) : -end(random_);
    sweep(from, to, 0.8);
    lengths.push_back(static_cast<std::uint32_t>(std::abs(to - from)) + 1);
    from = to;
    expect_identity();
    take([&](const Volume& volume) {
      const std::uint64_t index = volume.stamp().source_volume_index;
      EXPECT_NEAR(volume.stamp().frames, lengths[index], 2) << "sweep " << index;
      EXPECT_EQ(volume.stamp().direction == SweepDirection::kForward, index % 2 == 0);
    });
  }
  EXPECT_EQ(published(), 199U);
  EXPECT_EQ(counters_.frames_over_capacity.value(), 0U);
  EXPECT_EQ(counters_.frames_assembled.value() + assembler_.frames_pending(), sequence_);
}

TEST_F(TurningTest, BearsAPauseAtTheTurn) {
  std::uniform_real_distribution<double> jitter(-0.8, 0.8);
  for (int i = 0; i < 40; ++i) {
    i % 2 == 0 ? sweep(-15, 14, 0.8) : sweep(14, -15, 0.8);
    for (int pause = 0; pause < 6; ++pause) add_angle((i % 2 == 0 ? 28 : -30) + jitter(random_));
  }
  EXPECT_EQ(published(), 39U);
  EXPECT_EQ(counters_.frames_over_capacity.value(), 0U);
  expect_identity();
}

// Frames are close together where such a motor reverses, so the reversal is detected several frames late.
TEST_F(TurningTest, FollowsASineWithoutLosingFrames) {
  for (int i = 0; i < 30 * 20; ++i) {
    add_angle(29 * std::sin(std::numbers::pi * i / 30));
    // The first sweep is half of one.
    take([&](const Volume& volume) { EXPECT_EQ(volume.stamp().frames, i < 30 ? 16U : 30U); });
  }
  EXPECT_EQ(published(), 20U);
  EXPECT_EQ(counters_.frames_assembled.value() + assembler_.frames_pending(), sequence_);
  expect_identity();
}

TEST_F(TurningTest, CutsSweepsOfTwoFrames) {
  for (int i = 0; i < 20; ++i) add_angle(i / 2 % 2 == 0 ? -30 : 30);
  take([](const Volume& volume) { EXPECT_LE(volume.stamp().frames, 3U); });
  EXPECT_GE(published(), 8U);
  expect_identity();
}

TEST_F(TurningTest, GapsCountForTheSweepTheyAreIn) {
  sweep(-15, 0);
  sequence_ += 2;
  sweep(3, 14);
  sweep(14, -15);
  ASSERT_EQ(published(), 1U);
  EXPECT_EQ(ring_.take()->stamp().frames_missing, 2U);
  EXPECT_EQ(counters_.frames_missing.value(), 2U);
  assembler_.end_of_source();
  const auto last = ring_.take();
  EXPECT_EQ(last->stamp().frames_missing, 0U);
  EXPECT_EQ(last->stamp().direction, SweepDirection::kBackward);
  expect_identity();
}

TEST_F(TurningTest, AReorderedFrameIsNoTurn) {
  for (int place = -15; place <= 14; ++place) {
    if ((place + 15) % 7 != 2) {
      add_angle(2.0 * place);
      continue;
    }
    const FrameStamp early = {.sequence = sequence_++, .angle_rad = radians(2.0 * place)};
    add_angle(2.0 * ++place);
    EXPECT_TRUE(add(early));
  }
  EXPECT_EQ(counters_.frames_reordered.value(), 4U);
  assembler_.end_of_source();
  EXPECT_EQ(published(), 1U);
  EXPECT_EQ(ring_.take()->stamp().frames, 30U);
  expect_identity();
}

TEST_F(TurningTest, AFrameReorderedAcrossTheTurnGoesWithTheNextSweep) {
  sweep(-15, 12);
  const FrameStamp late = {.sequence = sequence_++, .angle_rad = radians(26)};
  add_angle(28);
  add_angle(28);
  EXPECT_TRUE(add(late));
  sweep(13, -15);
  ASSERT_EQ(published(), 1U);
  EXPECT_EQ(ring_.take()->stamp().frames_missing, 1U);
  assembler_.end_of_source();
  EXPECT_EQ(ring_.take()->stamp().frames, 31U);
  EXPECT_EQ(counters_.frames_missing.value(), 0U);
  expect_identity();
}

TEST_F(TurningTest, AMotorThatStandsFillsOneVolume) {
  for (int i = 0; i < 100; ++i) add_angle(-30);
  EXPECT_EQ(published(), 0U);
  EXPECT_EQ(counters_.frames_over_capacity.value(), 52U);
  assembler_.end_of_source();
  EXPECT_EQ(counters_.frames_in_short_volumes.value(), 48U);
  expect_identity();
}

TEST_F(TurningTest, AnotherGeometryEndsTheSweep) {
  sweep(-15, 14);
  sweep(14, -15);
  sweep(-15, 10);
  ++revision_;
  const auto changed = [&](double angle_deg) {
    return add({.sequence = sequence_++, .angle_rad = radians(angle_deg), .geometry_revision = revision_});
  };
  for (int place = 11; place <= 14; ++place) EXPECT_TRUE(changed(2.0 * place));
  EXPECT_EQ(published(), 3U) << "26 of 30 will do";
  for (int place = 14; place >= -15; --place) EXPECT_TRUE(changed(2.0 * place));
  EXPECT_EQ(counters_.geometry_changes.value(), 1U);
  expect_identity();
}

class TurningToAFile : public AssemblerTest {
 protected:
  TurningToAFile()
      : AssemblerTest({.policy = RingPolicy::kProcessAll,
                       .capacity = 48,
                       .config = {.cut = SweepCut::kByTurning, .range = {radians(-30), radians(30)}}}) {}
};

TEST_F(TurningToAFile, AStopAmidstTheTurnAbandonsTheFramesAfterIt) {
  int place = -15;
  int way = 1;
  // No reader: the ring fills up, and at the next reversal there is no free volume for the remaining frames.
  stop_.request_stop();
  while (counters_.frames_abandoned.value() == 0) {
    add({.sequence = sequence_++, .angle_rad = radians(2.0 * place)});
    place += way;
    if (std::abs(place) == 15) way = -way;
    expect_identity();
    ASSERT_LT(sequence_, 1000U);
  }
  EXPECT_EQ(published(), VolumeRing::Config{}.slots);
  EXPECT_EQ(assembler_.frames_pending(), 0U);
}

}  // namespace
}  // namespace fanlight
