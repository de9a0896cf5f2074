// SPDX-License-Identifier: Apache-2.0
// Repeated, late and reordered frames, gaps, and sequence restarts.
#include "tests/assembler/assembler_fixture.hpp"

namespace fanlight {
namespace {

class SequenceTest : public AssemblerTest {
 protected:
  SequenceTest() : AssemblerTest({.capacity = 40}) {}

  /// A sweep of 20 frames without the listed ones.
  void add_without(std::uint64_t volume_index, std::initializer_list<std::uint32_t> lost) {
    for (std::uint32_t i = 0; i < 20; ++i) {
      const FrameStamp stamp = frame(volume_index, i, 20);
      if (std::ranges::find(lost, i) == lost.end()) add(stamp);
    }
  }
};

TEST_F(SequenceTest, ARepeatedFrameIsCountedAndNotUsed) {
  add_sweep(0, 3, 20);
  FrameStamp again = frame(0, 2, 20);
  again.sequence = --sequence_ - 1;
  EXPECT_FALSE(add(again));
  EXPECT_EQ(counters_.frames_repeated.value(), 1U);
  EXPECT_EQ(assembler_.frames_pending(), 3U);
  expect_identity();
}

TEST_F(SequenceTest, AReorderedFrameIsUsedWhileItsSweepIsOpen) {
  add(frame(0, 0, 20));
  const FrameStamp late = frame(0, 1, 20);
  for (std::uint32_t i = 2; i < 19; ++i) add(frame(0, i, 20));
  EXPECT_TRUE(add(late));
  add(frame(0, 19, 20));
  EXPECT_EQ(counters_.frames_reordered.value(), 1U);
  EXPECT_EQ(counters_.frames_missing.value(), 0U);
  const auto volume = ring_.take();
  ASSERT_TRUE(volume);
  EXPECT_EQ(volume->stamp().frames, 20U);
  EXPECT_EQ(volume->stamp().frames_missing, 0U);
  EXPECT_EQ(volume->stamp().last_frame_sequence, 19U);
  const auto order = volume->by_angle();
  for (std::uint32_t i = 0; i < 20; ++i) EXPECT_EQ(volume->frame_pixels(order[i])[0], i);
  expect_identity();
}

TEST_F(SequenceTest, AFrameOfAClosedSweepIsLate) {
  add_sweep(0, 18, 20);
  const FrameStamp late = frame(0, 18, 20);
  add(frame(0, 19, 20));
  EXPECT_EQ(published(), 1U);
  EXPECT_FALSE(add(late));
  add(frame(1, 0, 20));
  EXPECT_FALSE(add(late));
  EXPECT_EQ(counters_.frames_late.value(), 2U);
  EXPECT_EQ(counters_.frames_missing.value(), 1U) << "when its sweep ended";
  EXPECT_EQ(ring_.take()->stamp().frames_missing, 1U);
  expect_identity();
}

TEST_F(SequenceTest, TheFirstFrameOfASweepMayComeSecond) {
  add_sweep(0, 20, 20);
  const FrameStamp first = frame(1, 0, 20);
  add(frame(1, 1, 20));
  EXPECT_TRUE(add(first));
  for (std::uint32_t i = 2; i < 20; ++i) add(frame(1, i, 20));
  EXPECT_EQ(counters_.frames_missing.value(), 0U);
  EXPECT_EQ(counters_.frames_reordered.value(), 1U);
  EXPECT_EQ(counters_.frames_assembled.value(), 40U);
  expect_identity();
}

TEST_F(SequenceTest, SomeFramesMayBeMissing) {
  add_without(0, {0, 7, 8});
  ASSERT_EQ(published(), 1U);
  EXPECT_EQ(ring_.take()->stamp().frames_missing, 3U);
  EXPECT_EQ(counters_.volumes_interpolated.value(), 1U);
  EXPECT_EQ(counters_.frames_missing.value(), 3U);
  add_without(1, {});
  EXPECT_EQ(ring_.take()->stamp().frames_missing, 0U);
  EXPECT_EQ(counters_.volumes_interpolated.value(), 1U);
}

TEST_F(SequenceTest, TooManyMissingFramesDropTheVolume) {
  add_without(0, {2, 7, 8, 12});
  EXPECT_EQ(published(), 0U);
  EXPECT_EQ(counters_.volumes_incomplete.value(), 1U);
  EXPECT_EQ(counters_.frames_in_incomplete_volumes.value(), 16U);
  EXPECT_EQ(counters_.frames_missing.value(), 4U);
  expect_identity();
}

TEST_F(SequenceTest, ALongGapDropsTheVolume) {
  for (std::uint32_t i = 0; i < 40; ++i) {
    const FrameStamp stamp = frame(0, i, 40);
    if (i < 10 || i > 13) add(stamp);
  }
  EXPECT_EQ(counters_.volumes_incomplete.value(), 1U) << "four of forty, but in a row";
  expect_identity();
}

TEST_F(SequenceTest, AFrameWithAFaultIsMissingFromItsVolume) {
  add_sweep(0, 10, 20);
  assembler_.reject(frame(0, 10, 20), FrameFault::kDamaged);
  for (std::uint32_t i = 11; i < 20; ++i) add(frame(0, i, 20));
  EXPECT_EQ(ring_.take()->stamp().frames_missing, 1U);
  EXPECT_EQ(counters_.frames_missing.value(), 0U);
  expect_identity();
}

TEST_F(SequenceTest, AMotorThatTurnedEarlyLeavesNothingMissing) {
  add_sweep(0, 17, 20);
  add_sweep(1, 20, 20);
  EXPECT_EQ(published(), 2U);
  EXPECT_EQ(counters_.frames_missing.value(), 0U);
  EXPECT_EQ(counters_.volumes_interpolated.value(), 0U);
}

TEST_F(SequenceTest, FramesLostAtTheEndOfASweepAreMissingFromIt) {
  add_sweep(0, 18, 20);
  sequence_ += 2;
  add_sweep(1, 20, 20);
  EXPECT_EQ(counters_.frames_missing.value(), 2U);
  EXPECT_EQ(counters_.volumes_interpolated.value(), 1U);
  EXPECT_EQ(published(), 2U);
}

TEST_F(SequenceTest, AGapOverTheTurnIsSharedOutByPlace) {
  add_sweep(0, 19, 20);
  sequence_ += 3;  // the last frame of the sweep and the first two of the next one are lost
  for (std::uint32_t i = 2; i < 20; ++i) add(frame(1, i, 20));
  EXPECT_EQ(counters_.frames_missing.value(), 3U);
  EXPECT_EQ(counters_.volumes_interpolated.value(), 2U);
  const auto newest = ring_.take();
  EXPECT_EQ(newest->stamp().frames_missing, 2U);
}

TEST_F(SequenceTest, LostSweepsAreMissingFromNoVolume) {
  add_sweep(0, 20, 20);
  sequence_ += 200;
  add_sweep(11, 20, 20);
  EXPECT_EQ(counters_.frames_missing.value(), 200U);
  EXPECT_EQ(published(), 2U);
  EXPECT_EQ(counters_.volumes_interpolated.value(), 0U);
}

TEST_F(SequenceTest, AnInterruptionGivesTheSweepUpAndCountsNoGap) {
  add_sweep(0, 20, 20);
  add(frame(1, 0, 20));
  ++sequence_;  // lost before the probe was unplugged
  add(frame(1, 2, 20));
  sequence_ = 700;
  for (std::uint32_t i = 12; i < 20; ++i) {
    FrameStamp stamp = frame(9, i, 20);
    stamp.after_interruption = i == 12;
    EXPECT_TRUE(add(stamp));
  }
  EXPECT_EQ(counters_.frames_missing.value(), 1U);
  EXPECT_EQ(counters_.frames_abandoned.value(), 2U + 8) << "a sweep that begins amidst is no volume";
  EXPECT_EQ(published(), 1U);
  add_sweep(10, 20, 20);
  EXPECT_EQ(published(), 2U);
  expect_identity();
}

TEST_F(SequenceTest, ARejectedFrameAfterAnInterruptionEndsTheSweepToo) {
  add_sweep(0, 5, 20);
  FrameStamp stamp = frame(3, 0, 20);
  stamp.sequence = 0;
  stamp.after_interruption = true;
  assembler_.reject(stamp, FrameFault::kDamaged);
  EXPECT_EQ(counters_.frames_abandoned.value(), 5U);
  EXPECT_EQ(counters_.frames_repeated.value(), 0U);
  expect_identity();
}

TEST_F(SequenceTest, AJumpOfTheSequenceIsARestartAndNoGap) {
  add_sweep(0, 5, 20);
  sequence_ = 5'000'000;
  add_sweep(0, 20, 20);
  EXPECT_EQ(counters_.sequence_restarts.value(), 1U);
  EXPECT_EQ(counters_.frames_missing.value(), 0U);
  EXPECT_EQ(counters_.frames_abandoned.value(), 5U);
  EXPECT_EQ(published(), 1U);
  expect_identity();
}

TEST_F(SequenceTest, AProbeThatBeganAnewByItselfIsFollowed) {
  for (std::uint64_t volume = 0; volume < 10; ++volume) add_sweep(volume, 20, 20);
  sequence_ = 0;
  add_sweep(0, 20, 20);
  EXPECT_EQ(counters_.sequence_restarts.value(), 1U);
  EXPECT_EQ(counters_.frames_late.value(), 1U) << "the first one alone could have been a straggler";
  EXPECT_EQ(counters_.frames_missing.value(), 0U);
  EXPECT_EQ(published(), 11U) << "without its first frame, which it can spare";
  add_sweep(1, 20, 20);
  EXPECT_EQ(published(), 12U);
  expect_identity();
}

TEST_F(SequenceTest, TheEndOfTheSourceSettlesWhatIsOpen) {
  add_sweep(0, 10, 0);
  ++sequence_;
  add(frame(0, 11, 0));
  EXPECT_EQ(counters_.frames_missing.value(), 0U);
  assembler_.end_of_source();
  EXPECT_EQ(counters_.frames_missing.value(), 1U);
  EXPECT_EQ(ring_.take()->stamp().frames_missing, 1U);
  EXPECT_EQ(counters_.frames_received.value() + counters_.frames_missing.value(), sequence_);
}

}  // namespace
}  // namespace fanlight
